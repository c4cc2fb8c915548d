#pragma once
// What a camera sees of a surface: a depth map drawn in software, so that it needs no graphics context and is the same
// everywhere. World frame and units; depth is z in the camera's frame. Every vertex goes through the whole camera model
// (skew, distortion); triangles are straight between their corners, so keep them small in strongly distorted pictures.
// Mirrored worlds (det R = -1) need nothing special: both sides of a triangle hide what lies behind.
#include <opencv2/core.hpp>

#include "capture/camera_model.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct DepthMap {
  cv::Mat depth;      // CV_32FC1: the nearest surface at the pixel's centre; infinity where there is none
  int downscale = 1;  // picture pixels a depth pixel, along each axis

  // Place in `depth` of a place in the picture, both counted from the centre of the first pixel.
  double from_picture(double coordinate) const { return (coordinate + 0.5) / downscale - 0.5; }
};

// Triangles with a corner that `camera` cannot project (behind it, beyond the fold of its distortion) are left out.
// Throws InvalidInput if the camera has no picture size or downscale < 1.
DepthMap render_depth(const TriangleMesh& mesh, const capture::CameraModel& camera, int downscale = 1);

}  // namespace rotunda::recon
