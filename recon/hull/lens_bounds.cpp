#include "recon/hull/lens_bounds.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace rotunda::recon {

double picture_radius(const capture::CameraModel& camera) {
  const Eigen::Matrix3d ideal_from_pixel = camera.K.inverse();
  constexpr int kSteps = 32;
  double radius = 0.0;
  for (int i = 0; i < 4 * kSteps; ++i) {
    const double along = static_cast<double>(i % kSteps) / kSteps;
    const double x = i / kSteps == 0 ? along : i / kSteps == 1 ? 1.0 : i / kSteps == 2 ? 1.0 - along : 0.0;
    const double y = i / kSteps == 0 ? 0.0 : i / kSteps == 1 ? along : i / kSteps == 2 ? 1.0 : 1.0 - along;
    const Eigen::Vector3d image =
        ideal_from_pixel * Eigen::Vector3d(x * camera.width - 0.5, y * camera.height - 0.5, 1.0);
    if (const auto ideal = capture::undistort(camera, image.head<2>())) radius = std::max(radius, ideal->norm());
  }
  return radius;
}

double largest_stretch(const capture::CameraModel& camera, double radius) {
  const auto& d = camera.distortion;
  double stretch = 1.0;
  for (int i = 0; i <= 16; ++i) {
    const double r2 = radius * radius * i / 16.0;
    stretch = std::max({stretch, 1.0 + r2 * (3.0 * d[0] + r2 * (5.0 * d[1] + r2 * 7.0 * d[4])),
                        1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))});
  }
  return stretch + 6.0 * radius * (std::abs(d[2]) + std::abs(d[3]));
}

}  // namespace rotunda::recon
