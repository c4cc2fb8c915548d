#include "capture/sync/silence_watch.h"

#include <algorithm>
#include <utility>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;

// From a trigger to its frame: exposure, the way here, and packets that are sent again.
constexpr std::chrono::nanoseconds kOnTheWay = 100ms - kLookForSilence;
constexpr std::chrono::nanoseconds kFirstFrame = 300ms;  // more at first, while everything starts

}  // namespace

SilenceWatch::SilenceWatch(std::size_t cameras, std::chrono::nanoseconds period)
    : cameras_(cameras), patience_(2 * period + kOnTheWay) {
  if (period.count() <= 0) throw InvalidInput("silence needs a trigger period longer than nothing");
}

void SilenceWatch::begin(Timestamp first_trigger) {
  for (auto& camera : cameras_) camera = {first_trigger + kFirstFrame, false};
}

bool SilenceWatch::heard(std::size_t camera, Timestamp now) {
  auto& one = cameras_.at(camera);
  one.heard = std::max(one.heard, now);
  return std::exchange(one.silent, false);
}

std::chrono::nanoseconds SilenceWatch::silent_for(std::size_t camera, Timestamp now) const {
  const auto& one = cameras_.at(camera);
  return one.silent ? std::max<std::chrono::nanoseconds>(now - one.heard, 0ns) : 0ns;
}

std::vector<std::size_t> SilenceWatch::look(Timestamp now) {
  std::vector<std::size_t> fallen;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].silent || now - cameras_[i].heard <= patience_) continue;
    cameras_[i].silent = true;
    fallen.push_back(i);
  }
  return fallen;
}

}  // namespace rotunda::capture
