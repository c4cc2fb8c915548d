#include "recon/neighbour_mattes.h"

#include <exception>

#include "capture/matte/chroma_key.h"
#include "capture/picture.h"
#include "recon/take_studio.h"

namespace rotunda::recon {

NeighbourMattes::Mattes NeighbourMattes::key(std::size_t frame) const {
  auto mattes = given_mattes(take_, frame);
  mattes.resize(studio_.cameras.size());
  const auto set = take_.read(frame);
  for (std::size_t i = 0; i < mattes.size(); ++i) {
    if (!mattes[i].alpha.empty()) continue;
    const auto picture = capture::picture_of(set.slots[i]);
    if (picture.rgb.empty()) continue;
    const cv::Mat stage = i < studio_.stages.size() ? studio_.stages[i] : cv::Mat();
    mattes[i] =
        capture::chroma_key(picture.rgb, {.backdrop = studio_.backdrop, .stage = stage}, studio_.backgrounds[i]);
  }
  return mattes;
}

// Who asks first keys; the others wait for it.
std::shared_future<NeighbourMattes::Mattes> NeighbourMattes::mattes_of(std::size_t frame) {
  std::promise<Mattes> promise;
  std::shared_future<Mattes> mattes;
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = kept_.find(frame); known != kept_.end()) return known->second;
    mattes = kept_[frame] = promise.get_future().share();
    if (kept_.size() > most_kept_) kept_.erase(kept_.begin());
  }
  try {
    promise.set_value(clock_.run("neighbours", [&] { return key(frame); }));
  } catch (...) {
    promise.set_exception(std::current_exception());
  }
  return mattes;
}

std::vector<cv::Mat> NeighbourMattes::held(std::size_t frame) {
  if (!studio_.live_keys.empty() || frame == 0 || frame + 1 >= take_.frame_set_count()) return {};
  const auto before = mattes_of(frame - 1), after = mattes_of(frame + 1);
  std::vector<cv::Mat> held;
  for (std::size_t i = 0; i < studio_.cameras.size(); ++i)
    held.push_back(capture::held_between(before.get()[i], after.get()[i]));
  return held;
}

}  // namespace rotunda::recon
