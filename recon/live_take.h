#pragma once
// A recorded take at live quality, for a look at it at once: every frame's coloured surface in one file, until the take
// is reconstructed in full. Layout, all numbers with the lower byte first: "RLT1", u32 frames, f32 frames a second; for
// each frame u32 bytes, 0 where there is no surface, and as many of live_surface.h.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <vector>

#include "recon/live_surface.h"

namespace rotunda::recon {

// Where it lies in a take.
std::filesystem::path live_take_file(const std::filesystem::path& take);

struct LiveTakeReport {
  std::size_t frames = 0, with_surface = 0;
  bool finished = false;  // else nothing was written
};

// `go_on` is asked before every few frames, and may wait; false ends it. Frames side by side on oneTBB's threads, the
// same file on any number of them. Throws what read_take_studio throws; std::system_error if it cannot be written.
LiveTakeReport make_live_take(const std::filesystem::path& take, const std::function<bool()>& go_on);

class LiveTakeReader {
 public:
  // Throws std::system_error; CorruptData, with the offset, for anything that make_live_take does not write.
  explicit LiveTakeReader(const std::filesystem::path& file);

  std::size_t frame_count() const { return frames_.size(); }
  double fps() const { return fps_; }
  // Nothing for a frame without surface. Throws InvalidInput beyond the last frame, CorruptData.
  std::optional<LiveSurface> read(std::size_t frame);

 private:
  struct Place {
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
  };

  std::filesystem::path file_;
  std::ifstream in_;
  double fps_ = 0.0;
  std::vector<Place> frames_;
};

}  // namespace rotunda::recon
