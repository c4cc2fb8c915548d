#pragma once
// What every camera of a calibration must keep, whichever file it came from, so that all readers refuse the same.
// Conventions are those of camera_model.h. Each returns what is wrong, one sentence that can follow "cam03: "; empty
// if nothing is, and only then is `camera` changed.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "capture/camera_model.h"

namespace rotunda::capture {

// The name becomes a file's (<camera>.mkv) and a folder's.
std::string set_name(CameraModel& camera, const std::string& name);
std::string set_image_size(CameraModel& camera, double width, double height);
// Upper triangular up to scale, focal lengths not zero.
std::string set_K(CameraModel& camera, const Eigen::Matrix3d& K);
// A rotation, mirrored or not, within 1e-3 (four written digits). Closer than 1e-9 it is kept as it is, else the
// nearest orthonormal matrix is taken.
std::string set_R(CameraModel& camera, const Eigen::Matrix3d& R);
// OpenCV's order k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty; 0, 4, 5, 8, 12 or 14 numbers. This project's model ends at
// k3: others must be zero.
std::string set_distortion(CameraModel& camera, const std::vector<double>& coefficients);

// A negative focal length is an axis of the camera turned round: K diag(s) . diag(s) (R x + t), s = +-1. In the turned
// plane the tangential terms change sign with their own axis (p1 with y, p2 with x).
void make_focal_lengths_positive(CameraModel& camera);

}  // namespace rotunda::capture
