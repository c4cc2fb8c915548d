#include "recon/take_outlines.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/errors.h"
#include "recon/frame_reconstruction.h"
#include "recon/take_plates.h"

namespace rotunda::recon {

TakeOutlines::TakeOutlines(const std::filesystem::path& take, const std::optional<std::filesystem::path>& calibration)
    : take_(take), studio_(read_take_studio(take_, calibration)) {
  if (studio_.views.cameras.size() < 2)
    throw InvalidInput(
        fmt::format("take {} has one camera; motion capture needs silhouettes from two or more", take_.info().name));
  clock_.run("plates", [&] {
    learn_missing_plates(take_, studio_.views);
    make_live_keys(take_, studio_.views);
  });
}

std::string TakeOutlines::where_to_look() const {
  return fmt::format("look at the mattes with `rotunda recon {} --frames 0:1 --mattes DIR`", take_.info().name);
}

// Silhouettes alone do without colours: the live key reads the camera's own pixels.
FrameViews TakeOutlines::keyed(std::size_t frame) {
  const auto set = clock_.run("read", [&] { return take_.read(frame); });
  const auto given = given_mattes(take_, frame);
  const bool quick = std::all_of(studio_.views.live_keys.begin(), studio_.views.live_keys.end(),
                                 [](const auto& key) { return key.has_value(); }) &&
                     !studio_.views.live_keys.empty() &&
                     std::all_of(given.begin(), given.end(), [](const auto& matte) { return matte.alpha.empty(); });
  if (!quick) return key_frame(set, studio_.views, given, clock_);
  FrameViews views;
  for (std::size_t i = 0; i < set.slots.size(); ++i) {
    if (!set.slots[i].frame) continue;
    views.cameras.push_back(studio_.views.cameras[i]);
    views.mattes.push_back(clock_.run("key", [&] { return (*studio_.views.live_keys[i])(set.slots[i].frame->image); }));
  }
  return views;
}

FrameOutlines TakeOutlines::outlines(std::size_t frame) {
  const auto views = keyed(frame);
  return clock_.run("outline", [&] {
    FrameOutlines result;
    for (std::size_t i = 0; i < views.cameras.size(); ++i)
      result.push_back({views.cameras[i], silhouette_outline(views.mattes[i])});
    return result;
  });
}

}  // namespace rotunda::recon
