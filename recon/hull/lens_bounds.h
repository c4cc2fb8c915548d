#pragma once
// How far a lens reaches on the ideal image plane (z = 1, undistorted), and how much it stretches there.
#include "capture/camera_model.h"

namespace rotunda::recon {

// The largest radius of any border pixel: the border lies farthest out.
double picture_radius(const capture::CameraModel& camera);

// Of the distortion within a radius: distances grow by no more than this factor.
double largest_stretch(const capture::CameraModel& camera, double radius);

}  // namespace rotunda::recon
