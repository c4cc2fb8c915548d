#pragma once
// What happened while a take was recorded, beside its frames: FOLDER/events.jsonl, one JSON object a line, appended as
// it happens, so that a killed writer's is whole up to the last. docs/take-format.md lists the lines.
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "capture/base/unique_fd.h"
#include "capture/frame.h"

namespace rotunda::capture {

// Something said at a trigger: by the operator (a mark) or by the rig (the clock stepped, a camera came back).
struct TakeRemark {
  std::uint64_t trigger = 0;
  std::string text;

  friend bool operator==(const TakeRemark&, const TakeRemark&) = default;
};

struct TakeJournal {
  std::map<std::uint64_t, std::map<CameraId, HoleReason>> missing;  // by trigger
  std::vector<TakeRemark> marks;
  std::vector<TakeRemark> incidents;
  std::vector<std::string> problems;  // lines that cannot be read
};

// A take without the file has an empty journal. A line cut short at the end is what a killed writer leaves: no problem.
// Throws std::system_error if the file is there and cannot be read.
TakeJournal read_take_journal(const std::filesystem::path& folder);

class TakeJournalWriter {
 public:
  // Throws std::system_error naming the file, as do the others. A line is whole in the file or not there.
  explicit TakeJournalWriter(const std::filesystem::path& folder);

  void missing(std::uint64_t trigger, const std::map<CameraId, HoleReason>& cameras);
  void mark(const TakeRemark& mark);
  void incident(const TakeRemark& incident);
  void sync() const;

 private:
  void append(const std::string& line);

  std::filesystem::path file_;
  UniqueFd fd_;
};

}  // namespace rotunda::capture
