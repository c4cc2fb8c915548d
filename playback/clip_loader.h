#pragma once
// Decodes all frames of a character in one thread of its own ("decode"), those of the first state first, so that it can
// be played while it is still being read. Frames wait in a short queue for the thread that draws.
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <filesystem>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "recon/motion/motion_graph.h"
#include "recon/sphere/geometry_image.h"

namespace rotunda::playback {

struct LoadedFrame {
  std::size_t clip = 0;
  int frame = 0;
  recon::GeometryImage image;  // in place
};

class ClipLoader {
 public:
  ClipLoader(std::filesystem::path character, const recon::MotionGraph& graph);

  // What has been decoded since last asked, a few frames at most. Throws what reading threw.
  std::vector<LoadedFrame> take();

 private:
  void decode(const std::stop_token& stop);

  std::filesystem::path character_;
  std::vector<std::pair<std::size_t, std::string>> clips_;  // number and name, in the order of reading
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<LoadedFrame> ready_;
  std::exception_ptr error_;
  std::jthread thread_;  // last: the first to end
};

}  // namespace rotunda::playback
