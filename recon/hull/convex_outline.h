#pragma once
// The convex hull of a silhouette: where lines and planes can touch it. On the camera's ideal image plane (x/z, y/z),
// where lens distortion is gone and straight lines are straight.
#include <Eigen/Core>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"

namespace rotunda::recon {

struct ConvexOutline {
  std::vector<Eigen::Vector2d> corners;  // in order around it; none: nobody in the matte
  bool is_cut = false;                   // it reaches the picture's border: there is more of the performer outside
};

// Of the matte's 127.5 contour, to a fraction of a pixel; pieces of less than a fiftieth of the largest are passed
// over. Throws InvalidInput, naming the camera, if the matte is not of the camera's size.
ConvexOutline convex_outline(const capture::CameraModel& camera, const capture::Matte& matte);

}  // namespace rotunda::recon
