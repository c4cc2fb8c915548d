#include "simulator/people/limb_pose.h"

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Along the leg in the bind pose, and the axis about which the knee flexes (the shank goes back).
struct LegAxes {
  Vector3d down, knee;
  LegAxes(const Skeleton& skeleton, Side side)
      : down(0.0, sign_of(side) * std::sin(skeleton.leg_angle), -std::cos(skeleton.leg_angle)),
        knee(0.0, std::cos(skeleton.leg_angle), sign_of(side) * std::sin(skeleton.leg_angle)) {}
};

Matrix3d frame_of(const Vector3d& first, const Vector3d& second) {
  Matrix3d frame;
  frame.col(0) = first.normalized();
  frame.col(1) = (second - frame.col(0) * frame.col(0).dot(second)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

// Law of cosines: the flexion at which hip and ankle are `distance` apart.
double knee_angle(double thigh, double shank, double distance) {
  const double c = (distance * distance - thigh * thigh - shank * shank) / (2.0 * thigh * shank);
  return std::acos(std::clamp(c, -1.0, 1.0));
}

}  // namespace

void place_foot(const Skeleton& skeleton, Pose& pose, Side side, const FootPlacement& foot) {
  const double s = sign_of(side);
  const LegAxes axes(skeleton, side);
  const Joint thigh = on_side(Joint::thigh_left, side);
  const Quaterniond& pelvis = pose.rotation[index(Joint::pelvis)];
  const Vector3d hip = pose.pelvis + pelvis * (skeleton.joint[index(thigh)] - skeleton.joint[index(Joint::pelvis)]);
  const Vector3d to_ankle = pelvis.inverse() * (foot.ankle - hip);  // in the pelvis's frame
  const Quaterniond knee(
      AngleAxisd(knee_angle(skeleton.thigh_length(), skeleton.shank_length(), to_ankle.norm()), axes.knee));
  const Vector3d chain = skeleton.thigh_length() * axes.down + skeleton.shank_length() * (knee * axes.down);
  const Quaterniond turned_out(AngleAxisd(s * foot.toe_out, Vector3d::UnitZ()));
  const Quaterniond lateral = pelvis.inverse() * turned_out;
  const Quaterniond hip_turn(
      Matrix3d(frame_of(to_ankle, lateral * Vector3d::UnitY()) * frame_of(chain, axes.knee).transpose()));
  const Quaterniond foot_turn = turned_out * Quaterniond(AngleAxisd(-foot.pitch, Vector3d::UnitY()));
  pose.rotation[index(thigh)] = hip_turn;
  pose.rotation[index(on_side(Joint::shank_left, side))] = knee;
  pose.rotation[index(on_side(Joint::foot_left, side))] = (pelvis * hip_turn * knee).inverse() * foot_turn;
  pose.rotation[index(on_side(Joint::toes_left, side))] = Quaterniond(AngleAxisd(-foot.toe_bend, Vector3d::UnitY()));
}

double ankle_height(const Skeleton& skeleton) {
  return skeleton.joint[index(Joint::foot_left)].z();
}

void place_arm(const Skeleton& skeleton, Pose& pose, Side side, const ArmAngles& arm) {
  const double s = sign_of(side), bind = skeleton.arm_angle;
  const Vector3d elbow_axis(0.0, -std::cos(bind), -s * std::sin(bind));
  pose.rotation[index(on_side(Joint::upper_arm_left, side))] =
      Quaterniond(AngleAxisd(-arm.flexion, Vector3d::UnitY())) *
      Quaterniond(AngleAxisd(-s * (bind - arm.abduction), Vector3d::UnitX()));
  pose.rotation[index(on_side(Joint::forearm_left, side))] = Quaterniond(AngleAxisd(arm.elbow, elbow_axis));
}

double knee_flexion(const Pose& pose, Side side) {
  return AngleAxisd(pose.rotation[index(on_side(Joint::shank_left, side))]).angle();
}

}  // namespace rotunda::simulator
