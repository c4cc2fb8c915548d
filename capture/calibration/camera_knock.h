#pragma once
// A camera that was knocked while the board was shown: found in how its views disagree, named by what fits the whole
// rig best.
#include <optional>
#include <string>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

// A camera's pose changed between two moments of its own views.
struct Knock {
  std::size_t camera = 0;
  std::size_t last_before = 0, first_after = 0;  // moments
  double shift_px = 0.0;                         // mean over the corners of its views
  CameraModel after;                             // world to camera, as it stood from first_after on
};

// `sightings` with outliers, `noise_px` a corner's standard deviation a axis. Whether any camera moved is measured by
// how much a camera's views disagree without any knock (Fisher's F over views): that holds the corners' noise as well
// as what lens and board model miss. Boards are posed by all cameras together, so the neighbours of a knocked one
// disagree too: every camera is then given a second pose in turn, everything adjusted anew with the intrinsics held,
// and the one that leaves the least is named. Where cameras saw few boards, a knock hides in lenses and poses: there
// every place it may have happened is tried, lenses free, and must better the whole rig. Nothing if all stood still as
// far as can be told.
std::optional<Knock> find_knock(const RigState& state, std::span<const Sighting> sightings,
                                std::span<const Board> boards, double noise_px);

// "cam04 moved between m012 and m013, by 12.0 px".
std::string in_words(const Knock& knock, const RigState& state, std::span<const std::string> moments);

}  // namespace rotunda::capture
