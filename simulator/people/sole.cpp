#include "simulator/people/sole.h"

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d heading(double yaw) {
  return {std::cos(yaw), std::sin(yaw)};
}

}  // namespace

Quaterniond foot_frame(double yaw, double pitch) {
  return Quaterniond(AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(-pitch, Vector3d::UnitY()));
}

Sole::Sole(const Skeleton& skeleton) : ankle_height_(ankle_height(skeleton)) {
  const Vector3d toes = skeleton.joint[index(Joint::toes_left)], ankle = skeleton.joint[index(Joint::foot_left)];
  const double scale = scale_ = skeleton.height / 1.75;
  ball_ = {toes.x() - ankle.x(), toes.z()};
  a_ = 0.036 * scale;
  b_ = 0.30 * a_;
  heel_centre_ = {-0.036 * scale, 0.012 * scale - ankle_height_};
}

FootSpot Sole::spot_at(const Vector2d& ankle, double yaw) const {
  return {ankle + ball_.x() * heading(yaw), yaw};
}

Vector2d Sole::flat_ankle(const FootSpot& spot) const {
  return spot.ball - ball_.x() * heading(spot.yaw);
}

LegPlacement Sole::standing(const FootSpot& spot, double pitch) const {
  const Vector2d along = ankle_at(pitch), ankle = flat_ankle(spot) + along.x() * heading(spot.yaw);
  LegPlacement leg;
  leg.ankle = {ankle.x(), ankle.y(), along.y()};
  leg.foot = foot_frame(spot.yaw, pitch);
  leg.knee << heading(spot.yaw), 0.0;
  leg.toe_bend = std::max(0.0, -pitch);
  return leg;
}

double Sole::heel_parameter(double pitch) const {
  return std::atan2(a_ * std::sin(pitch), b_ * std::cos(pitch));
}

void Sole::lift_over_floor(LegPlacement& leg, double clearance) const {
  const Vector3d heel(-0.060 * scale_, 0.0, 0.006 * scale_ - ankle_height_);
  const Vector3d ball(ball_.x(), 0.0, ball_.y() - ankle_height_);
  const Quaterniond toes(AngleAxisd(-leg.toe_bend, Vector3d::UnitY()));
  const Vector3d tip = ball + toes * Vector3d(0.060 * scale_, 0.0, 0.003 * scale_ - ball_.y());
  const auto height = [&](const Vector3d& point) { return leg.ankle.z() + (leg.foot * point).z(); };
  const double lowest =
      std::min({height(heel) - 0.006 * scale_, height(ball) - ball_.y(), height(tip) - 0.003 * scale_});
  leg.ankle.z() += std::max(0.0, clearance - lowest);
}

// The length of sole from the flat part to the point that touches the floor.
double Sole::heel_arc(double pitch) const {
  constexpr int kSteps = 24;
  const double end = heel_parameter(pitch);
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double u = end * (i + 0.5) / kSteps;
    sum += std::hypot(a_ * std::cos(u), b_ * std::sin(u)) * end / kSteps;
  }
  return sum;
}

Vector2d Sole::ankle_at(double pitch) const {
  const Rotation2Dd rotated(pitch);
  if (pitch < 0.0) return Vector2d(ball_ + rotated * Vector2d(-ball_.x(), ankle_height_ - ball_.y()));
  const double u = heel_parameter(pitch);
  const Vector2d contact = heel_centre_ + Vector2d(-a_ * std::sin(u), -b_ * std::cos(u));
  Vector2d ankle = Vector2d(heel_centre_.x() - heel_arc(pitch), 0.0) - rotated * contact;
  ankle.y() += ankle_height_ + heel_centre_.y() - b_;  // as the flat sole lies in the bind pose
  return ankle;
}

}  // namespace rotunda::simulator
