#pragma once
// What a camera's status says, from what its source tells. Pure; FrameRate remembers a second.
#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>

#include "capture/source/source.h"
#include "rig/client.h"

namespace rotunda::rig {

void tell_stats(CameraStatus& status, const capture::SourceStats& stats);
void tell_description(CameraStatus& status, const capture::SourceDescription& description);
void tell_health(CameraStatus& status, const capture::SourceHealth& health);  // an empty one: nothing is known

// What the operator reads: what is wrong, worst first, and what to do. `silent`: no pictures come though they should;
// `ailment`: what its stream was cured of.
std::string problems_of(const capture::SourceDescription& description, const capture::SourceHealth& health, bool silent,
                        const std::string& ailment);

class FrameRate {
 public:
  // Frames a second over the last second or so; 0 until half a second is known. Fewer frames than before: opened anew.
  double measure(std::uint64_t frames, std::chrono::steady_clock::time_point now);
  void forget() { counts_.clear(); }

 private:
  std::deque<std::pair<std::chrono::steady_clock::time_point, std::uint64_t>> counts_;
};

}  // namespace rotunda::rig
