#include "capture/calibration/camera_rules.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace rotunda::capture {
namespace {

constexpr int kLargestSide = 65536;            // pixels
constexpr std::size_t kLongestName = 200;      // bytes; file systems take 255 with an ending
constexpr double kRotationTolerance = 1e-3;    // |R R^T - I|: four written digits; more is a mistake
constexpr double kRoundingTolerance = 1e-9;    // below it R is as good as doubles written in full
constexpr double kTriangularTolerance = 1e-9;  // below K's diagonal, in units of the focal length
constexpr const char* kNames[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tx", "ty"};
constexpr std::size_t kKept = 5;  // k1 k2 p1 p2 k3

}  // namespace

std::string set_name(CameraModel& camera, const std::string& name) {
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == '/' || c == '\\'; };
  if (name.empty() || name.front() == '.' || name.size() > kLongestName ||
      std::any_of(name.begin(), name.end(), control))
    return "expected a name that can name a file: not empty, no slash, no leading dot";
  camera.name = name;
  return {};
}

std::string set_image_size(CameraModel& camera, double width, double height) {
  for (const double side : {width, height})
    if (!(side >= 1 && side <= kLargestSide && side == std::floor(side)))
      return fmt::format("expected whole pixels from 1 to {}, found {}", kLargestSide, side);
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  return {};
}

std::string set_K(CameraModel& camera, const Eigen::Matrix3d& given) {
  if (!given.allFinite()) return "every number must be finite; found infinity or NaN";
  if (std::abs(given(2, 2)) < 1e-12) return "expected 1 in the lower right corner, found 0";
  Eigen::Matrix3d K = given;
  if (K(2, 2) != 1.0) K = Eigen::Matrix3d(given / given(2, 2));
  const double focal_length = std::max(std::abs(K(0, 0)), std::abs(K(1, 1)));
  if (std::max({std::abs(K(1, 0)), std::abs(K(2, 0)), std::abs(K(2, 1))}) > kTriangularTolerance * (1.0 + focal_length))
    return "expected an upper triangular matrix (fx skew cx, 0 fy cy, 0 0 1)";
  if (std::min(std::abs(K(0, 0)), std::abs(K(1, 1))) < 1e-6)
    return fmt::format("focal lengths must not be zero, found {} and {} px", K(0, 0), K(1, 1));
  camera.K = K.triangularView<Eigen::Upper>();
  return {};
}

std::string set_R(CameraModel& camera, const Eigen::Matrix3d& R) {
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kRotationTolerance))
    return fmt::format("expected a rotation (or a mirrored one); R R^T is off by {:.2g}", error);
  camera.R = R;
  if (error <= kRoundingTolerance) return {};
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  camera.R = svd.matrixU() * svd.matrixV().transpose();
  return {};
}

std::string set_distortion(CameraModel& camera, const std::vector<double>& c) {
  const std::size_t n = c.size();
  if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14)
    return fmt::format("expected 0, 4, 5, 8, 12 or 14 numbers in OpenCV's order (k1 k2 p1 p2 k3 ...), found {}", n);
  for (const double value : c)
    if (!std::isfinite(value)) return "every number must be finite; found infinity or NaN";
  for (std::size_t i = kKept; i < n; ++i)
    if (c[i] != 0.0)
      return fmt::format("{} = {} cannot be kept (k1 k2 p1 p2 k3 are); calibrate again with five coefficients",
                         kNames[i], c[i]);
  camera.distortion.setZero();
  for (std::size_t i = 0; i < std::min(n, kKept); ++i) camera.distortion[static_cast<Eigen::Index>(i)] = c[i];
  return {};
}

void make_focal_lengths_positive(CameraModel& camera) {
  const Eigen::Vector3d sign(camera.K(0, 0) < 0 ? -1 : 1, camera.K(1, 1) < 0 ? -1 : 1, 1);
  if (sign == Eigen::Vector3d::Ones()) return;
  camera.K = Eigen::Matrix3d(camera.K * sign.asDiagonal());
  camera.R = Eigen::Matrix3d(sign.asDiagonal() * camera.R);
  camera.t = Eigen::Vector3d(sign.asDiagonal() * camera.t);
  camera.distortion[2] *= sign.y();
  camera.distortion[3] *= sign.x();
}

}  // namespace rotunda::capture
