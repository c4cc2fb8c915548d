#include "recon/body/limb_starts.h"

#include <numbers>
#include <utility>

namespace rotunda::recon {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;

struct Arm {
  BodyJoint clavicle, upper, forearm, hand;
};
constexpr Arm kLeft{BodyJoint::clavicle_left, BodyJoint::upper_arm_left, BodyJoint::forearm_left, BodyJoint::hand_left};
constexpr Arm kRight{BodyJoint::clavicle_right, BodyJoint::upper_arm_right, BodyJoint::forearm_right,
                     BodyJoint::hand_right};

Quaterniond& turn(Pose& pose, BodyJoint joint) {
  return pose.rotation[index(joint)];
}

// The elbow stays where it is; the forearm goes round it, bent by so much.
Pose bent(Pose pose, const Arm& arm, double round, double bend) {
  const auto& upper = range_of(arm.upper);
  turn(pose, arm.upper) = turn(pose, arm.upper) * Quaterniond(AngleAxisd(round, upper.bone));
  const auto& elbow = range_of(arm.forearm);
  const double way = elbow.hinge.dot(elbow.low + elbow.high) > 0.0 ? 1.0 : -1.0;
  turn(pose, arm.forearm) = rotation_at(elbow, way * bend * elbow.hinge);
  turn(pose, arm.hand) = Quaterniond::Identity();
  return within_limits(pose);
}

Pose as_the_other(Pose pose, const Arm& arm) {
  const auto mirror = mirrored(pose);
  for (const auto joint : {arm.clavicle, arm.upper, arm.forearm, arm.hand})
    turn(pose, joint) = mirror.rotation[index(joint)];
  return pose;
}

}  // namespace

std::vector<Pose> other_arms(const Pose& pose) {
  constexpr double kQuarter = std::numbers::pi / 2.0;
  constexpr double kLittle = 0.5, kWell = 1.9;  // radians
  std::vector<Pose> poses;
  for (const auto& arm : {kLeft, kRight}) {
    for (const double bend : {kLittle, kWell})
      for (int quarter = 0; quarter < 4; ++quarter) poses.push_back(bent(pose, arm, quarter * kQuarter, bend));
    poses.push_back(as_the_other(pose, arm));
  }
  return poses;
}

Pose legs_swapped(const Pose& pose) {
  const auto mirror = mirrored(pose);
  Pose result = pose;
  for (std::size_t j = index(BodyJoint::thigh_left); j < kBodyJoints; ++j) result.rotation[j] = mirror.rotation[j];
  return result;
}

std::vector<Pose> other_legs(const Pose& pose) {
  constexpr double kForwards = -0.9, kBack = 0.3;  // of the thigh about the pelvis' y, radians
  constexpr double kStraight = 0.1, kBent = 1.4;   // of the knee
  std::vector<Pose> poses;
  for (const auto& [thigh, shank] : {std::pair(BodyJoint::thigh_left, BodyJoint::shank_left),
                                     std::pair(BodyJoint::thigh_right, BodyJoint::shank_right)})
    for (const double swing : {kForwards, kBack})
      for (const double bend : {kStraight, kBent}) {
        auto other = pose;
        turn(other, thigh) = Quaterniond(AngleAxisd(swing, Eigen::Vector3d::UnitY()));
        turn(other, shank) = rotation_at(range_of(shank), bend * range_of(shank).hinge);
        poses.push_back(within_limits(other));
      }
  return poses;
}

}  // namespace rotunda::recon
