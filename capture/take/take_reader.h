#pragma once
// Reads a take: frame sets by number, put together from the cameras' files by trigger. Works as well on a take whose
// writer was killed and on files cut short: what cannot be read is a hole that says why.
// Opening throws ConfigError or InvalidInput for the take's own files; a camera's file that is damaged or missing is
// a problem(), not an exception. Several threads may read at once.
#include <filesystem>
#include <string>
#include <vector>

#include "capture/take/camera_file_reader.h"
#include "capture/take/take.h"
#include "capture/take/take_journal.h"

namespace rotunda::capture {

class TakeReader {
 public:
  explicit TakeReader(const std::filesystem::path& folder);

  // As take.yaml has it, but start and counts as found in the files (frames with damaged pixels still count here;
  // take_verify.h looks at the pixels).
  const TakeInfo& info() const { return info_; }
  const std::filesystem::path& folder() const { return folder_; }
  const TakeJournal& journal() const { return journal_; }
  const std::vector<std::string>& problems() const { return problems_; }  // files that are missing or damaged

  std::size_t frame_set_count() const { return info_.frame_sets; }
  // Frame set `index`, trigger info().first_trigger + index. Throws InvalidInput beyond the last, std::system_error
  // if the disk fails.
  FrameSet read(std::size_t index) const;
  Timestamp time_of(std::size_t index) const;  // the moment its trigger was scheduled for
  // One camera's slot of it, cheaper if only that is wanted; `camera` as in info().cameras.
  FrameSlot read(std::size_t index, std::size_t camera) const;

  // In each camera's file, the frames no trigger can be told of: their records are damaged.
  std::size_t unplaced_frames(std::size_t camera) const { return unplaced_[camera]; }

 private:
  void place_frames();
  void count();
  void count_reasons();
  HoleReason why_missing(std::size_t index, std::size_t camera) const;
  const StoredFrame* find(std::size_t index, std::size_t camera) const;

  std::filesystem::path folder_;
  TakeInfo info_;
  std::vector<CameraFileReader> files_;
  std::vector<std::vector<StoredFrame>> placed_;  // by camera, with records, triggers rising
  std::vector<std::size_t> unplaced_;
  TakeJournal journal_;
  std::vector<std::string> problems_;
};

}  // namespace rotunda::capture
