#pragma once
// The garbage matte: which pixels of a camera can show the capture volume at all. Whatever else is in view (the
// screen's edge, lamps, the ceiling) is no performer, whatever its colour.
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "capture/camera_model.h"

namespace rotunda::capture {

// CV_8UC1 of the camera's size: 255 where a pixel's ray meets `volume` (world, in the camera's unit) in front of the
// camera, and up to `margin_px` beside such pixels: what a calibration may be off. 0 elsewhere.
cv::Mat stage_mask(const CameraModel& camera, const Eigen::AlignedBox3d& volume, int margin_px = 8);

}  // namespace rotunda::capture
