#include "capture/camera_model.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

struct Coefficients {
  double k1, k2, p1, p2, k3;
  explicit Coefficients(const CameraModel& camera)
      : k1(camera.distortion[0]),
        k2(camera.distortion[1]),
        p1(camera.distortion[2]),
        p2(camera.distortion[3]),
        k3(camera.distortion[4]) {}

  double radial(double r2) const { return 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)); }
  // d(r radial(r)) / dr: negative or zero beyond the radius where the image folds over.
  double radial_slope(double r2) const { return 1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)); }
};

// Beyond the smallest radius at which the slope vanishes the polynomial folds back: no pixel belongs there.
bool within_fold(const Coefficients& c, double r2) {
  constexpr int kSteps = 16;  // the slope is a cubic in r^2: sixteen samples find its first sign change
  for (int i = 1; i <= kSteps; ++i)
    if (c.radial_slope(r2 * i / kSteps) <= 0.0) return false;
  return true;
}

Eigen::Matrix2d distortion_jacobian(const Coefficients& c, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double radial = c.radial(r2);
  const double slope = 2.0 * (c.k1 + r2 * (2.0 * c.k2 + 3.0 * r2 * c.k3));  // d radial / d(r^2), times 2
  Eigen::Matrix2d jacobian;
  jacobian(0, 0) = radial + x * x * slope + 2.0 * c.p1 * y + 6.0 * c.p2 * x;
  jacobian(0, 1) = x * y * slope + 2.0 * c.p1 * x + 2.0 * c.p2 * y;
  jacobian(1, 0) = jacobian(0, 1);
  jacobian(1, 1) = radial + y * y * slope + 6.0 * c.p1 * y + 2.0 * c.p2 * x;
  return jacobian;
}

}  // namespace

Eigen::Vector2d distort(const CameraModel& camera, const Eigen::Vector2d& ideal) {
  const Coefficients c(camera);
  const double x = ideal.x(), y = ideal.y(), r2 = ideal.squaredNorm();
  const double radial = c.radial(r2);
  return {x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x),
          y * radial + c.p1 * (r2 + 2.0 * y * y) + 2.0 * c.p2 * x * y};
}

std::optional<Eigen::Vector2d> undistort(const CameraModel& camera, const Eigen::Vector2d& distorted) {
  if (camera.distortion.isZero(0.0)) return distorted;
  const Coefficients c(camera);
  Eigen::Vector2d ideal = distorted;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Eigen::Vector2d residual = distort(camera, ideal) - distorted;
    if (residual.norm() < 1e-12) break;
    const Eigen::Matrix2d jacobian = distortion_jacobian(c, ideal);
    if (std::abs(jacobian.determinant()) < 1e-9) return std::nullopt;
    ideal -= jacobian.inverse() * residual;
    if (!ideal.allFinite()) return std::nullopt;
  }
  if ((distort(camera, ideal) - distorted).norm() > 1e-9 || !within_fold(c, ideal.squaredNorm())) return std::nullopt;
  return ideal;
}

std::optional<Eigen::Vector2d> project(const CameraModel& camera, const Eigen::Vector3d& point_in_world) {
  const Eigen::Vector3d point = camera.R * point_in_world + camera.t;
  if (point.z() <= 1e-3) return std::nullopt;
  Eigen::Vector2d image = point.head<2>() / point.z();
  if (!camera.distortion.isZero(0.0)) {
    if (!within_fold(Coefficients(camera), image.squaredNorm())) return std::nullopt;
    image = distort(camera, image);
  }
  return Eigen::Vector2d(camera.K.topLeftCorner<2, 2>() * image + camera.K.topRightCorner<2, 1>());
}

std::optional<Eigen::Vector3d> ray_through(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d distorted = camera.K.inverse() * pixel.homogeneous();
  const auto ideal = undistort(camera, distorted.head<2>() / distorted.z());
  if (!ideal) return std::nullopt;
  return Eigen::Vector3d((camera.R.transpose() * ideal->homogeneous()).normalized());
}

CameraModel without_distortion(const CameraModel& camera) {
  CameraModel pinhole = camera;
  pinhole.distortion.setZero();
  return pinhole;
}

cv::Mat undistort_image(const CameraModel& camera, const cv::Mat& image, const cv::Scalar& border) {
  if (camera.distortion.isZero(0.0)) return image.clone();
  const Eigen::Matrix3d image_from_pixel = camera.K.inverse();
  cv::Mat source_of(image.size(), CV_32FC2);
  const Coefficients c(camera);
  for (int y = 0; y < image.rows; ++y) {
    auto* row = source_of.ptr<cv::Vec2f>(y);
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector3d ideal = image_from_pixel * Eigen::Vector3d(x, y, 1.0);
      const Eigen::Vector2d p = ideal.head<2>() / ideal.z();
      if (!within_fold(c, p.squaredNorm())) {
        row[x] = {-1e6F, -1e6F};
        continue;
      }
      const Eigen::Vector2d source = (camera.K * distort(camera, p).homogeneous()).head<2>();
      row[x] = {static_cast<float>(source.x()), static_cast<float>(source.y())};
    }
  }
  cv::Mat result;
  cv::remap(image, result, source_of, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT, border);
  return result;
}

}  // namespace rotunda::capture
