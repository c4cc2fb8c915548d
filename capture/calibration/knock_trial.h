#pragma once
// Whose knock it was. Boards are posed by all cameras together, so a knocked camera disturbs its neighbours, and its
// own residuals may look no worse than theirs. What tells is the whole rig: the camera moved with which everything else
// fits best.
#include "capture/calibration/camera_faults.h"

namespace rotunda::capture {

// `suspect` is a knock that is certain to have happened. Every camera that saw boards before and after it is given a
// second pose in turn and everything is adjusted anew, intrinsics held; the knock of the one that leaves the least is
// returned. `sightings` with outliers, `noise_px` a corner's standard deviation a axis.
Knock whose_knock(const Knock& suspect, const RigState& state, std::span<const Sighting> sightings,
                  std::span<const Board> boards, double noise_px);

}  // namespace rotunda::capture
