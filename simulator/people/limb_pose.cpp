#include "simulator/people/limb_pose.h"

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond turn(double angle, const Vector3d& axis) {
  return Quaterniond(AngleAxisd(angle, axis));
}

// Along a limb in the bind pose, and the axis about which its middle joint flexes.
struct LimbAxes {
  Vector3d along, hinge;
};
LimbAxes leg_axes(const Skeleton& skeleton, Side side) {
  const double s = sign_of(side), a = skeleton.leg_angle;
  return {{0.0, s * std::sin(a), -std::cos(a)}, {0.0, std::cos(a), s * std::sin(a)}};
}
LimbAxes arm_axes(const Skeleton& skeleton, Side side) {
  const double s = sign_of(side), a = skeleton.arm_angle;
  return {{0.0, s * std::sin(a), -std::cos(a)}, {0.0, -std::cos(a), -s * std::sin(a)}};
}

Quaterniond world_rotation(const Pose& pose, Joint joint) {
  Quaterniond rotation = pose.rotation[index(joint)];
  while (parent_of(joint) != joint) {
    joint = parent_of(joint);
    rotation = pose.rotation[index(joint)] * rotation;
  }
  return rotation;
}

Vector3d world_centre(const Skeleton& skeleton, const Pose& pose, Joint joint) {
  Vector3d offset = Vector3d::Zero();
  for (; parent_of(joint) != joint; joint = parent_of(joint)) {
    const Joint parent = parent_of(joint);
    offset = pose.rotation[index(parent)] * (offset + skeleton.joint[index(joint)] - skeleton.joint[index(parent)]);
  }
  return pose.pelvis + offset;
}

Matrix3d frame_of(const Vector3d& first, const Vector3d& second) {
  Matrix3d frame;
  frame.col(0) = first.normalized();
  frame.col(1) = (second - frame.col(0) * frame.col(0).dot(second)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

// Law of cosines: the flexion at which the ends of two bones are `distance` apart.
double flexion_for(double upper, double lower, double distance) {
  const double c = (distance * distance - upper * upper - lower * lower) / (2.0 * upper * lower);
  return std::acos(std::clamp(c, -1.0, 1.0));
}

// A distance the limb can span, and comes to it smoothly: equal to `wanted` up to 1 - `margin` of the length.
double soft_reach(double wanted, double length, double margin) {
  const double start = (1.0 - margin) * length, room = margin * length;
  return wanted <= start ? wanted : start + room * (1.0 - std::exp(-(wanted - start) / room));
}

double upper_arm_length(const Skeleton& skeleton) {
  return (skeleton.joint[index(Joint::forearm_left)] - skeleton.joint[index(Joint::upper_arm_left)]).norm();
}
double forearm_length(const Skeleton& skeleton) {
  return (skeleton.joint[index(Joint::hand_left)] - skeleton.joint[index(Joint::forearm_left)]).norm();
}

// Turns about `axis` alone that a rotation holds (swing-twist).
double twist_about(const Quaterniond& rotation, const Vector3d& axis) {
  return 2.0 * std::atan2(rotation.vec().dot(axis), rotation.w());
}
double wrapped(double angle) {
  return std::remainder(angle, 2.0 * std::numbers::pi);
}

double signed_angle(const Quaterniond& rotation, const Vector3d& axis) {
  return wrapped(twist_about(rotation, axis));
}

}  // namespace

LegPlacement leg_with(const Skeleton& skeleton, const Pose& pose, Side side, const LegAngles& angles) {
  const double s = sign_of(side);
  const Vector3d down = -Vector3d::UnitZ(), y = Vector3d::UnitY();
  const Quaterniond thigh = world_rotation(pose, Joint::pelvis) * turn(-angles.hip, y) *
                            turn(s * angles.abduction, Vector3d::UnitX()) *
                            turn(s * angles.rotation, Vector3d::UnitZ());
  const Quaterniond shank = thigh * turn(angles.knee, y);
  const Vector3d hip = world_centre(skeleton, pose, on_side(Joint::thigh_left, side));
  LegPlacement leg;
  leg.ankle = hip + skeleton.thigh_length() * (thigh * down) + skeleton.shank_length() * (shank * down);
  leg.foot = shank * turn(-angles.ankle, y);
  leg.knee = thigh * turn(0.5 * angles.knee, y) * Vector3d::UnitX();
  leg.slack = 1.0;
  return leg;
}

void place_leg(const Skeleton& skeleton, Pose& pose, Side side, const LegPlacement& leg) {
  const LimbAxes axes = leg_axes(skeleton, side);
  const Joint thigh = on_side(Joint::thigh_left, side);
  const Quaterniond from_world = world_rotation(pose, Joint::pelvis).inverse();
  const Vector3d to_ankle = from_world * (leg.ankle - world_centre(skeleton, pose, thigh));
  const double upper = skeleton.thigh_length(), lower = skeleton.shank_length();
  const double margin = 0.005 + 0.02 * std::min(1.0, leg.slack / 0.05);  // a standing foot is reached exactly
  const double flexion = flexion_for(upper, lower, soft_reach(to_ankle.norm(), upper + lower, margin));
  const Quaterniond knee = turn(flexion, axes.hinge);
  const Vector3d chain = upper * axes.along + lower * (knee * axes.along);
  const Vector3d hinge = (from_world * leg.knee).cross(to_ankle);
  const Quaterniond hip(Matrix3d(frame_of(to_ankle, hinge) * frame_of(chain, axes.hinge).transpose()));
  pose.rotation[index(thigh)] = hip;
  pose.rotation[index(on_side(Joint::shank_left, side))] = knee;
  pose.rotation[index(on_side(Joint::foot_left, side))] = (hip * knee).inverse() * from_world * leg.foot;
  pose.rotation[index(on_side(Joint::toes_left, side))] = turn(-leg.toe_bend, Vector3d::UnitY());
}

void place_arm(const Skeleton& skeleton, Pose& pose, Side side, const ArmAngles& angles) {
  const double s = sign_of(side);
  const LimbAxes axes = arm_axes(skeleton, side);
  const Vector3d x = Vector3d::UnitX();
  pose.rotation[index(on_side(Joint::upper_arm_left, side))] =
      turn(-angles.flexion, Vector3d::UnitY()) * turn(s * angles.abduction, x) *
      turn(-s * angles.rotation, Vector3d::UnitZ()) * turn(-s * skeleton.arm_angle, x);
  // The forearm's bones turn about each other: half of it shows at the elbow's end.
  const Quaterniond half_pronation = turn(s * 0.5 * angles.pronation, axes.along);
  pose.rotation[index(on_side(Joint::forearm_left, side))] = turn(angles.elbow, axes.hinge) * half_pronation;
  const Vector3d palm = axes.along.cross(x) * s, flexion_axis = axes.along.cross(palm);
  pose.rotation[index(on_side(Joint::hand_left, side))] = half_pronation * turn(angles.wrist, flexion_axis);
}

HandPlacement hand_of(const Skeleton& skeleton, const Pose& pose, Side side) {
  const Joint hand = on_side(Joint::hand_left, side), forearm = on_side(Joint::forearm_left, side);
  HandPlacement placement;
  placement.wrist = world_centre(skeleton, pose, hand);
  placement.hand = world_rotation(pose, hand);
  const Vector3d shoulder = world_centre(skeleton, pose, on_side(Joint::upper_arm_left, side));
  const Quaterniond upper = world_rotation(pose, on_side(Joint::upper_arm_left, side));
  const Vector3d reach = placement.wrist - shoulder, elbow = world_centre(skeleton, pose, forearm) - shoulder;
  const Vector3d outwards = elbow - reach * (elbow.dot(reach) / reach.squaredNorm());
  // Of a straight arm the elbow points where it would go if it bent.
  placement.elbow = (outwards - 0.02 * (upper * Vector3d::UnitX())).normalized();
  return placement;
}

void place_hand(const Skeleton& skeleton, Pose& pose, Side side, const HandPlacement& hand) {
  const LimbAxes axes = arm_axes(skeleton, side);
  const Joint upper_arm = on_side(Joint::upper_arm_left, side);
  const Quaterniond from_world = world_rotation(pose, parent_of(upper_arm)).inverse();
  const Vector3d to_wrist = from_world * (hand.wrist - world_centre(skeleton, pose, upper_arm));
  const double upper = upper_arm_length(skeleton), lower = forearm_length(skeleton);
  const double flexion = flexion_for(upper, lower, soft_reach(to_wrist.norm(), upper + lower, 0.02));
  const Quaterniond elbow = turn(flexion, axes.hinge);
  const Vector3d chain = upper * axes.along + lower * (elbow * axes.along);
  const Vector3d hinge = (from_world * hand.elbow).cross(to_wrist);
  const Quaterniond shoulder(Matrix3d(frame_of(to_wrist, hinge) * frame_of(chain, axes.hinge).transpose()));
  const Quaterniond turned = (shoulder * elbow).inverse() * from_world * hand.hand;
  const Quaterniond half_twist = turn(0.5 * wrapped(twist_about(turned, axes.along)), axes.along);
  pose.rotation[index(upper_arm)] = shoulder;
  pose.rotation[index(on_side(Joint::forearm_left, side))] = elbow * half_twist;
  pose.rotation[index(on_side(Joint::hand_left, side))] = half_twist.inverse() * turned;
}

Quaterniond hand_towards(const Skeleton& skeleton, Side side, const Vector3d& along, const Vector3d& palm) {
  const Vector3d bind_along = arm_axes(skeleton, side).along;
  const Vector3d bind_palm = bind_along.cross(Vector3d::UnitX()) * sign_of(side);
  return Quaterniond(Matrix3d(frame_of(along, palm) * frame_of(bind_along, bind_palm).transpose()));
}

double reachable_pelvis_height(const Skeleton& skeleton, const Pose& pose, const std::array<LegPlacement, 2>& legs) {
  constexpr double kBlend = 0.006;  // metres over which the limits take over
  double sum = 1.0;
  for (const Side side : {Side::left, Side::right}) {
    const auto& leg = legs[side == Side::left ? 0 : 1];
    const Vector3d hip = world_centre(skeleton, pose, on_side(Joint::thigh_left, side));
    const double length = 0.993 * (skeleton.thigh_length() + skeleton.shank_length()) + leg.slack;
    const double across = (leg.ankle - hip).head<2>().norm();
    if (across >= length) continue;
    const double above = leg.ankle.z() + std::sqrt(length * length - across * across) - hip.z();  // room to the limit
    sum += std::exp(-std::clamp(above, -0.6, 0.6) / kBlend);
  }
  return pose.pelvis.z() - kBlend * std::log(sum);
}

double ankle_height(const Skeleton& skeleton) {
  return skeleton.joint[index(Joint::foot_left)].z();
}

double leg_scale(const Skeleton& skeleton) {
  constexpr double kLegOfReference = 0.485 * 1.75;
  return (skeleton.thigh_length() + skeleton.shank_length()) / kLegOfReference;
}

double knee_flexion(const Skeleton& skeleton, const Pose& pose, Side side) {
  return signed_angle(pose.rotation[index(on_side(Joint::shank_left, side))], leg_axes(skeleton, side).hinge);
}

double elbow_flexion(const Skeleton& skeleton, const Pose& pose, Side side) {
  const LimbAxes axes = arm_axes(skeleton, side);
  const Quaterniond& forearm = pose.rotation[index(on_side(Joint::forearm_left, side))];
  const Quaterniond bent = forearm * turn(twist_about(forearm, axes.along), axes.along).inverse();
  return signed_angle(bent, axes.hinge);
}

}  // namespace rotunda::simulator
