#include "recon/body/skeleton.h"

#include <cmath>
#include <numbers>

namespace rotunda::recon {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

constexpr std::array<std::string_view, kBodyJoints> kNames = {
    "pelvis",          "spine",          "chest",        "neck",       "head",
    "clavicle_left",   "upper_arm_left", "forearm_left", "hand_left",  "clavicle_right",
    "upper_arm_right", "forearm_right",  "hand_right",   "thigh_left", "shank_left",
    "foot_left",       "thigh_right",    "shank_right",  "foot_right"};
constexpr std::array<int, kBodyJoints> kParents = {-1, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16, 17};
constexpr std::array<int, kBodyJoints> kMirrors = {0, 1, 2, 3, 4, 9, 10, 11, 12, 5, 6, 7, 8, 16, 17, 18, 13, 14, 15};

JointRange ball(const Vector3d& bone, const Vector3d& low_deg, const Vector3d& high_deg,
                const Quaterniond& centre = Quaterniond::Identity()) {
  return {.motion = JointMotion::ball,
          .bone = bone,
          .centre = centre,
          .low = low_deg * kDegree,
          .high = high_deg * kDegree};
}

// A mirror at y = 0 turns a rotation vector's x and z about.
JointRange mirrored(JointRange range) {
  const Vector3d low = range.low, high = range.high;
  range.low = {-high.x(), low.y(), -high.z()};
  range.high = {-low.x(), high.y(), -low.z()};
  range.bone.y() = -range.bone.y();
  range.hinge = {-range.hinge.x(), range.hinge.y(), -range.hinge.z()};
  range.centre = Quaterniond(range.centre.w(), -range.centre.x(), range.centre.y(), -range.centre.z());
  return range;
}

Quaterniond about(const Vector3d& axis, double degrees) {
  return Quaterniond(AngleAxisd(degrees * kDegree, axis));
}

std::array<JointRange, kBodyJoints> make_ranges() {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  std::array<JointRange, kBodyJoints> ranges;
  const auto of = [&](BodyJoint joint) -> JointRange& { return ranges[index(joint)]; };
  of(BodyJoint::pelvis).motion = JointMotion::free;
  of(BodyJoint::spine) = ball(z, {-35, -35, -35}, {35, 60, 35});
  of(BodyJoint::chest) = ball(z, {-30, -35, -40}, {30, 45, 40});
  of(BodyJoint::neck) = ball(z, {-50, -65, -75}, {50, 65, 75});
  // Raised by the shoulder blade, drawn forwards and back.
  of(BodyJoint::clavicle_left) = ball(y, {-15, -10, -30}, {45, 10, 25});
  // Around an arm that hangs half way down and a little forwards.
  of(BodyJoint::upper_arm_left) = ball(y, {-75, -95, -115}, {135, 95, 75}, about(z, -25) * about(x, -45));
  of(BodyJoint::forearm_left) = {.motion = JointMotion::hinge_and_twist,
                                 .bone = y,
                                 .hinge = -z,
                                 .low = Vector3d(0, -95, -165) * kDegree,
                                 .high = Vector3d(0, 95, 10) * kDegree};
  of(BodyJoint::hand_left) = ball(y, {-85, -10, -45}, {85, 10, 45});
  of(BodyJoint::thigh_left) = ball(-z, {-45, -105, -60}, {75, 75, 60}, about(y, -35));
  of(BodyJoint::shank_left) = {.motion = JointMotion::hinge,
                               .bone = -z,
                               .hinge = y,
                               .low = Vector3d(0, -10, 0) * kDegree,
                               .high = Vector3d(0, 165, 0) * kDegree};
  of(BodyJoint::foot_left) = ball(x, {-40, -40, -30}, {40, 70, 30});
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    if (kMirrors[j] > static_cast<int>(j)) ranges[static_cast<std::size_t>(kMirrors[j])] = mirrored(ranges[j]);
  return ranges;
}

double turn_about(const Quaterniond& rotation, const Vector3d& axis) {
  const double angle = 2.0 * std::atan2(rotation.vec().dot(axis), rotation.w());
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

Vector3d rotation_vector(const Quaterniond& rotation) {
  const AngleAxisd turn(rotation.w() < 0.0 ? Quaterniond(-rotation.coeffs()) : rotation);
  return turn.angle() * turn.axis();
}

Quaterniond from_rotation_vector(const Vector3d& vector) {
  const double angle = vector.norm();
  return angle < 1e-12 ? Quaterniond::Identity() : Quaterniond(AngleAxisd(angle, vector / angle));
}

}  // namespace

std::string_view to_string(BodyJoint joint) {
  return kNames[index(joint)];
}

std::optional<BodyJoint> parent_of(BodyJoint joint) {
  const int parent = kParents[index(joint)];
  return parent < 0 ? std::nullopt : std::optional(static_cast<BodyJoint>(parent));
}

BodyJoint mirrored(BodyJoint joint) {
  return static_cast<BodyJoint>(kMirrors[index(joint)]);
}

const JointRange& range_of(BodyJoint joint) {
  static const auto ranges = make_ranges();
  return ranges[index(joint)];
}

Vector3d range_coordinates(const JointRange& range, const Quaterniond& rotation) {
  switch (range.motion) {
    case JointMotion::rigid:
      return Vector3d::Zero();
    case JointMotion::hinge:
      return turn_about(rotation, range.hinge) * range.hinge;
    case JointMotion::hinge_and_twist: {
      // rotation = turn(hinge) * twist(bone), as u x v = bone with u the hinge: both angles out of where the axes go.
      const Vector3d bone = rotation * range.bone, side = range.hinge.cross(range.bone);
      const double turn = std::atan2(bone.dot(side), bone.dot(range.bone));
      const Quaterniond twist = Quaterniond(AngleAxisd(-turn, range.hinge)) * rotation;
      return turn * range.hinge + turn_about(twist, range.bone) * range.bone;
    }
    case JointMotion::free:
    case JointMotion::ball:
      break;
  }
  const Quaterniond away = range.centre.conjugate() * rotation;
  const double twist = turn_about(away, range.bone);
  const Quaterniond swing = away * Quaterniond(AngleAxisd(-twist, range.bone));
  return rotation_vector(swing) + twist * range.bone;
}

Quaterniond rotation_at(const JointRange& range, const Vector3d& coordinates) {
  const double twist = coordinates.dot(range.bone);
  const Quaterniond about_bone(AngleAxisd(twist, range.bone));
  switch (range.motion) {
    case JointMotion::rigid:
      return Quaterniond::Identity();
    case JointMotion::hinge:
      return Quaterniond(AngleAxisd(coordinates.dot(range.hinge), range.hinge));
    case JointMotion::hinge_and_twist:
      return Quaterniond(AngleAxisd(coordinates.dot(range.hinge), range.hinge)) * about_bone;
    case JointMotion::free:
    case JointMotion::ball:
      break;
  }
  return range.centre * from_rotation_vector(coordinates - twist * range.bone) * about_bone;
}

double Skeleton::leg_length() const {
  return offset[index(BodyJoint::shank_left)].norm() + offset[index(BodyJoint::foot_left)].norm();
}

}  // namespace rotunda::recon
