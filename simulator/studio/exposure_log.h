#pragma once
// exposures.jsonl: which camera showed which act frame when, a line an exposure (docs/simulator-truth.md). Appended
// while the cameras stream by a thread of its own, "exposure log"; every line is written in one piece, so what is there
// can be read at any time and after any end.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "simulator/gige/gige_studio.h"

namespace rotunda::simulator {

class ExposureLog {
 public:
  // Begins the file anew. Throws std::system_error if it cannot be written.
  ExposureLog(const std::filesystem::path& file, std::vector<std::string> cameras);
  ~ExposureLog();  // writes what was told

  // From any thread; never waits. What does not fit in the queue of 10 000 is lost and counted.
  void add(const Exposure& exposure, int act_frame);
  std::uint64_t lost() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rotunda::simulator
