#include "rig/daemon/picture_watch.h"

#include <pthread.h>

#include <algorithm>

#include "capture/picture.h"
#include "rig/camera_portraits.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kLookEvery = 500ms;
constexpr int kShareOfACore = 20;  // one in so many
constexpr auto kOld = 5s;

}  // namespace

PictureWatch::PictureWatch() : thread_([this](std::stop_token stop) { run(std::move(stop)); }) {}

void PictureWatch::offer(const capture::FrameSet& set) {
  const std::lock_guard lock(mutex_);
  if (newest_ || SteadyClock::now() < next_look_) return;
  newest_ = set;
  wake_.notify_one();
}

std::optional<capture::PictureHealth> PictureWatch::health(const capture::CameraId& camera) const {
  const std::lock_guard lock(mutex_);
  const auto found = looks_.find(camera);
  if (found == looks_.end() || SteadyClock::now() - found->second.at > kOld) return std::nullopt;
  return found->second.health;
}

cv::Mat PictureWatch::portrait(const capture::CameraId& camera, SteadyClock::time_point asked) const {
  const std::lock_guard lock(mutex_);
  const auto found = looks_.find(camera);
  return found != looks_.end() && found->second.at >= asked ? found->second.portrait : cv::Mat();
}

void PictureWatch::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "picture watch");
  while (!stop.stop_requested()) {
    std::optional<capture::FrameSet> set;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, stop, [this] { return newest_.has_value(); });
      if (!newest_) return;
      set = newest_;
    }
    const auto begun = SteadyClock::now();
    for (const auto& slot : set->slots)
      if (slot.frame && !stop.stop_requested()) look_at(slot);
    const std::lock_guard lock(mutex_);
    const auto spent = SteadyClock::now() - begun;
    next_look_ = begun + std::max<SteadyClock::duration>(kLookEvery, kShareOfACore * spent);
    newest_.reset();
  }
}

void PictureWatch::look_at(const capture::FrameSlot& slot) {
  const auto picture = capture::picture_of(slot);
  if (picture.rgb.empty()) return;  // a damaged JPEG
  const Look look{capture::picture_health(picture.rgb), portrait_picture(picture.rgb), SteadyClock::now()};
  const std::lock_guard lock(mutex_);
  looks_[slot.frame->camera] = look;
}

}  // namespace rotunda::rig
