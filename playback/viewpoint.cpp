#include "playback/viewpoint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace rotunda::playback {

Viewpoint viewpoint_of(const capture::CameraModel& camera) {
  return {.width = camera.width,
          .height = camera.height,
          .K = camera.K,
          .distortion = camera.distortion,
          .R = camera.R,
          .t = camera.t};
}

Viewpoint magnified(const Viewpoint& viewpoint, int factor) {
  Viewpoint larger = viewpoint;
  larger.width *= factor;
  larger.height *= factor;
  Eigen::Matrix3d scale = Eigen::Vector3d(factor, factor, 1.0).asDiagonal();
  scale(0, 2) = scale(1, 2) = (factor - 1) / 2.0;  // pixels are named by their centres
  larger.K = scale * viewpoint.K;
  return larger;
}

void Orbit::turn(double azimuth_change, double elevation_change) {
  constexpr double kSteepest = 85.0 * std::numbers::pi / 180.0;  // at 90 degrees "up" is undefined
  azimuth = std::remainder(azimuth + azimuth_change, 2.0 * std::numbers::pi);
  elevation = std::clamp(elevation + elevation_change, -kSteepest, kSteepest);
}

void Orbit::zoom(double factor) {
  distance = std::clamp(distance / factor, 0.05, 1000.0);
}

Eigen::Vector3d Orbit::shift(const Eigen::Vector2d& heights) const {
  const auto eye = viewpoint(2, 2);
  const double metres = 2.0 * distance * std::tan(0.5 * field_of_view);
  return -metres * (heights.x() * eye.R.row(0) + heights.y() * eye.R.row(1)).transpose();
}

Viewpoint Orbit::viewpoint(int width, int height) const {
  const Eigen::Vector3d outwards(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                 std::sin(elevation));
  const Eigen::Vector3d forward = -outwards, right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Viewpoint view{.width = width, .height = height};
  view.R << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  view.t = -view.R * (target + distance * outwards);
  const double focal = 0.5 * height / std::tan(0.5 * field_of_view);
  view.K << focal, 0.0, 0.5 * (width - 1), 0.0, focal, 0.5 * (height - 1), 0.0, 0.0, 1.0;
  return view;
}

Orbit orbit_around(const Eigen::AlignedBox3d& box, double field_of_view, double aspect) {
  // Seen from the side: half the height, and the half diagonal of the floor plan, which is the widest it turns.
  const double half_height = 0.5 * box.sizes().z(), half_width = 0.5 * box.sizes().head<2>().norm();
  const double slope = std::tan(0.5 * field_of_view);
  Orbit orbit{.target = box.center(), .field_of_view = field_of_view};
  constexpr double kMargin = 1.1;
  orbit.distance = std::max(kMargin * std::max(half_height, half_width / aspect) / slope + half_width, 0.05);
  return orbit;
}

DepthRange depth_range(const Viewpoint& viewpoint, const Eigen::AlignedBox3d& box) {
  double nearest = std::numeric_limits<double>::max(), farthest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const double z =
        viewpoint.R.row(2) * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) + viewpoint.t.z();
    nearest = std::min(nearest, z);
    farthest = std::max(farthest, z);
  }
  farthest = std::max(1.01 * farthest, 1e-3);
  return {std::max(0.99 * nearest, 1e-3 * farthest), farthest};  // 24 bits of depth bear 1 : 1000 well
}

Eigen::Matrix3d device_from_ideal(const Viewpoint& viewpoint) {
  const double w = viewpoint.width, h = viewpoint.height;
  Eigen::Matrix3d device_from_pixel;  // pixel centres lie half a pixel inside the picture's corner
  device_from_pixel << 2.0 / w, 0.0, 1.0 / w - 1.0, 0.0, -2.0 / h, 1.0 - 1.0 / h, 0.0, 0.0, 1.0;
  return device_from_pixel * viewpoint.K;
}

double fold_radius_squared(const Viewpoint& viewpoint) {
  const double k1 = viewpoint.distortion[0], k2 = viewpoint.distortion[1], k3 = viewpoint.distortion[4];
  constexpr double kReach = 16.0;  // radius 4: 76 degrees off the axis, beyond any picture of this model
  constexpr int kSteps = 1024;
  for (int i = 1; i <= kSteps; ++i) {
    const double r2 = kReach * i / kSteps;
    if (1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) <= 0.0) return kReach * (i - 1) / kSteps;
  }
  return 1e9;
}

}  // namespace rotunda::playback
