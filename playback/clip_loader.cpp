#include "playback/clip_loader.h"

#include <pthread.h>

#include <algorithm>

#include "recon/motion/character.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {
namespace {

constexpr std::size_t kAhead = 4;  // frames waiting

}  // namespace

ClipLoader::ClipLoader(std::filesystem::path character, const recon::MotionGraph& graph)
    : character_(std::move(character)) {
  for (std::size_t i = 0; i < graph.clips.size(); ++i) clips_.emplace_back(i, graph.clips[i].name);
  const auto& first = graph.state(graph.start).clip;
  std::stable_partition(clips_.begin(), clips_.end(), [&](const auto& clip) { return clip.second == first; });
  thread_ = std::jthread([this](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "decode");
    try {
      decode(stop);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
  });
}

void ClipLoader::decode(const std::stop_token& stop) {
  for (const auto& [number, name] : clips_) {
    recon::GeometryVideoReader video(recon::clip_video_of(character_, name));
    for (int frame = 0; frame < video.frame_count(); ++frame) {
      auto image = video.read(frame, {.in_place = true, .drawn = true});
      std::unique_lock lock(mutex_);
      changed_.wait(lock, stop, [&] { return ready_.size() < kAhead; });
      if (stop.stop_requested()) return;
      ready_.push_back({number, frame, std::move(image)});
    }
  }
}

std::vector<LoadedFrame> ClipLoader::take() {
  std::vector<LoadedFrame> frames;
  {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
    for (auto& frame : ready_) frames.push_back(std::move(frame));
    ready_.clear();
  }
  changed_.notify_all();
  return frames;
}

}  // namespace rotunda::playback
