#pragma once
// A rigid motion over the floor: a turn about the vertical, then a shift. What clips are laid end to end with (Kovar,
// Gleicher, Pighin 2002). Metres, radians; poses read target_from_source.
#include <Eigen/Core>
#include <cmath>

namespace rotunda::recon {

struct FloorPose {
  double x = 0.0, y = 0.0;
  double yaw = 0.0;  // counter-clockwise seen from above

  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {c * p.x() - s * p.y() + x, s * p.x() + c * p.y() + y};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const {
    const Eigen::Vector2d at = *this * Eigen::Vector2d(p.head<2>());
    return {at.x(), at.y(), p.z()};
  }
  FloorPose operator*(const FloorPose& other) const {
    const Eigen::Vector2d at = *this * Eigen::Vector2d(other.x, other.y);
    return {at.x(), at.y(), yaw + other.yaw};
  }
  FloorPose inverse() const {
    const Eigen::Vector2d at = FloorPose{0.0, 0.0, -yaw} * Eigen::Vector2d(-x, -y);
    return {at.x(), at.y(), -yaw};
  }
  // A turn about a point that stays where it is.
  static FloorPose turn_about(const Eigen::Vector2d& pivot, double yaw) {
    const Eigen::Vector2d moved = pivot - FloorPose{0.0, 0.0, yaw} * pivot;
    return {moved.x(), moved.y(), yaw};
  }
};

}  // namespace rotunda::recon
