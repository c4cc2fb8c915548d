#pragma once
// With a first calibration every board can be looked for where it must be: the detector misses steep and half-seen
// ones. Corners are fitted anew with the print as this very camera sees it there, and refused where they are not near.
#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

struct MissedBoardOptions {
  double least_cosine = 0.15;  // between the board's normal and the way to the camera: flatter views are left
  double reach_px = 1.0;       // of the prediction
  double blur_px = 0.8;        // where the camera has no sighting that tells
};

// One camera's sighting of a board whose pose is known, in its grey picture as linear light; no corners: not seen.
Sighting look_where_predicted(const cv::Mat& linear, const RigState& state, const BoardPrint& print,
                              const Sighting& which, const MissedBoardOptions& options = {});

}  // namespace rotunda::capture
