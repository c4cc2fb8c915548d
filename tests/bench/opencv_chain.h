#pragma once
// A rig calibrated by OpenCV's own means, as the baseline: its corners, calibrateCamera for each camera,
// stereoCalibrate from camera to camera.
#include <vector>

#include "capture/calibration/bundle_adjustment.h"
#include "capture/camera_model.h"
#include "tests/bench/calibration_scene.h"

namespace rotunda::bench {

// By camera. Which end of a chessboard is first is told by truth, so that the chain has only its own errors.
std::vector<std::vector<capture::Sighting>> opencv_corners(const Scene& scene);

// Each camera by itself, then the next nearest by shared boards to one that stands (Prim), pair by pair; the world is
// the first camera's frame.
std::vector<capture::CameraModel> opencv_chain(const Scene& scene,
                                               const std::vector<std::vector<capture::Sighting>>& sightings);

}  // namespace rotunda::bench
