#include "recon/hull/epipolar_tangents.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace rotunda::recon {
namespace {

using capture::CameraModel;

constexpr double kWidest = 2.6;  // radians between the tangents; half a turn is an epipole on the outline

Tangent tangent_at(const CameraModel& camera, const Eigen::Vector2d& corner, const Pencil& pencil) {
  const Eigen::Vector3d y = corner.homogeneous(), ray = camera.R.transpose() * y;
  const double a = ray.dot(pencil.u), b = ray.dot(pencil.v);
  // In the camera's frame; a mirrored world's turns come out right as they are taken after it.
  const Eigen::Vector3d gradient = camera.R * (pencil.v * a - pencil.u * b) / (a * a + b * b);
  return {std::atan2(b, a), corner, gradient.head<2>().norm() / focal_px(camera), gradient.cross(y)};
}

}  // namespace

double focal_px(const CameraModel& camera) {
  return std::sqrt(std::abs(camera.K.topLeftCorner<2, 2>().determinant()));
}

Pencil pencil_of(const CameraModel& a, const CameraModel& b, const Eigen::Vector3d& towards) {
  const Eigen::Vector3d along = (b.centre() - a.centre()).normalized();
  const Eigen::Vector3d u = (towards - along * along.dot(towards)).normalized();
  return {u, along.cross(u)};
}

std::optional<Tangents> tangents(const CameraModel& camera, const ConvexOutline& outline, const Pencil& pencil) {
  const Eigen::Vector3d u = camera.R * pencil.u, v = camera.R * pencil.v;
  double lowest = 10.0, highest = -10.0;
  Eigen::Vector2d at_lowest, at_highest;
  for (const auto& corner : outline.corners) {
    const double angle = std::atan2(corner.homogeneous().dot(v), corner.homogeneous().dot(u));
    if (angle < lowest) lowest = angle, at_lowest = corner;
    if (angle > highest) highest = angle, at_highest = corner;
  }
  if (outline.corners.empty() || highest - lowest >= kWidest) return std::nullopt;
  return Tangents{tangent_at(camera, at_lowest, pencil), tangent_at(camera, at_highest, pencil)};
}

}  // namespace rotunda::recon
