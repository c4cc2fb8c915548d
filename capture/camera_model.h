#pragma once
// Camera model: pinhole with skew and Brown-Conrady distortion, as calibration.yaml holds it (OpenCV's conventions).
// Camera frame: x right, y down, z forward; x_in_camera = R x_in_world + t. World: metres, right-handed, z up.
// Pixel (0, 0) is the centre of the top-left pixel. OpenCV's own functions ignore K[0][1]; these do not.
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace rotunda::capture {

struct CameraModel {
  std::string name;
  int width = 0;                                                                 // pixels
  int height = 0;                                                                // pixels
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();                               // fx, skew, cx; 0, fy, cy; 0, 0, 1
  Eigen::Matrix<double, 5, 1> distortion = Eigen::Matrix<double, 5, 1>::Zero();  // k1 k2 p1 p2 k3
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();                               // camera_from_world
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double rms_px = 0.0;  // of the calibration; 0 if not known

  Eigen::Vector3d centre() const { return -R.transpose() * t; }  // in world
  // Direction of the optical axis, in world, unit length.
  Eigen::Vector3d axis() const { return R.row(2).transpose(); }
};

// Ideal image plane (x/z, y/z) to distorted ideal plane, and back (fixed-point then Newton; nothing if it does not
// converge, which happens only outside the lens's valid field).
Eigen::Vector2d distort(const CameraModel& camera, const Eigen::Vector2d& ideal);
std::optional<Eigen::Vector2d> undistort(const CameraModel& camera, const Eigen::Vector2d& distorted);

// Pixel of a world point; nothing if the point is not in front of the camera (z <= 1 mm in the unit of t) or lies
// beyond the radius where the distortion folds over.
std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& point_in_world);

// Unit direction in world of the ray through a pixel, from centre().
std::optional<Eigen::Vector3d> ray_through(const CameraModel& camera, const Eigen::Vector2d& pixel);

// The image with distortion removed: same size and K, so that the remaining model is a pinhole with skew. The second
// value is that pinhole. Interpolates linearly; outside the source is `border`.
cv::Mat undistort_image(const CameraModel& camera, const cv::Mat& image, const cv::Scalar& border = {});
CameraModel without_distortion(const CameraModel& camera);

}  // namespace rotunda::capture
