#pragma once
// Reads every frame of a take and checks it against its CRC-32C: what a take holds, as opposed to what it says.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "capture/take/take.h"

namespace rotunda::capture {

// `done` of `total` frame sets; called by the thread that called the function it was given to.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

struct CameraReport {
  CameraId name;
  std::size_t frames = 0;   // whole, as they were recorded
  std::size_t missing = 0;  // frame sets in which this camera has no whole frame
  std::size_t corrupt = 0;  // frames in the file that are not what was recorded
};

// A run of frame sets without one camera's frame.
struct FrameGap {
  CameraId camera;
  std::uint64_t first_trigger = 0;
  std::size_t frames = 0;
};

struct TakeReport {
  std::string name;
  TakeState state = TakeState::recording;
  std::uint64_t first_trigger = 0;
  std::size_t frame_sets = 0;
  std::size_t complete = 0;
  std::size_t incomplete = 0;
  std::vector<CameraReport> cameras;
  std::vector<FrameGap> gaps;
  std::vector<std::string> problems;  // files that are missing or damaged

  // Closed, and every frame of every camera there.
  bool whole() const;
};

// Throws what TakeReader does; std::system_error operation_canceled when stopped.
TakeReport verify_take(const std::filesystem::path& folder, const Progress& progress = {}, std::stop_token stop = {});

}  // namespace rotunda::capture
