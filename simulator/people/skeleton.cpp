#include "simulator/people/skeleton.h"

#include <cmath>
#include <numbers>

namespace rotunda::simulator {
namespace {

constexpr std::array<Joint, kJoints> kParents = {
    Joint::pelvis,        Joint::pelvis,         Joint::spine,        Joint::chest,      Joint::neck,
    Joint::chest,         Joint::upper_arm_left, Joint::forearm_left, Joint::chest,      Joint::upper_arm_right,
    Joint::forearm_right, Joint::pelvis,         Joint::thigh_left,   Joint::shank_left, Joint::foot_left,
    Joint::pelvis,        Joint::thigh_right,    Joint::shank_right,  Joint::foot_right,
};

constexpr std::array<std::string_view, kJoints> kNames = {
    "pelvis",    "spine",           "chest",         "neck",       "head",       "upper_arm_left", "forearm_left",
    "hand_left", "upper_arm_right", "forearm_right", "hand_right", "thigh_left", "shank_left",     "foot_left",
    "toes_left", "thigh_right",     "shank_right",   "foot_right", "toes_right"};

void place_leg(Skeleton& skeleton, Side side, double h) {
  const double s = sign_of(side);
  const Eigen::Vector3d down(0.0, s * std::sin(skeleton.leg_angle), -std::cos(skeleton.leg_angle));
  auto& joint = skeleton.joint;
  const auto at = [&](Joint left) -> Eigen::Vector3d& { return joint[index(on_side(left, side))]; };
  at(Joint::thigh_left) = Eigen::Vector3d(0.0, s * 0.0525 * h, 0.535 * h);
  at(Joint::shank_left) = at(Joint::thigh_left) + 0.245 * h * down;
  at(Joint::foot_left) = at(Joint::shank_left) + 0.240 * h * down;
  at(Joint::toes_left) = at(Joint::foot_left) + Eigen::Vector3d(0.077 * h, 0.0, 0.0);
  at(Joint::toes_left).z() = 0.016 * h;
}

void place_arm(Skeleton& skeleton, Side side, double h) {
  const double s = sign_of(side);
  const Eigen::Vector3d out(0.0, s * std::sin(skeleton.arm_angle), -std::cos(skeleton.arm_angle));
  auto& joint = skeleton.joint;
  const auto at = [&](Joint left) -> Eigen::Vector3d& { return joint[index(on_side(left, side))]; };
  at(Joint::upper_arm_left) = Eigen::Vector3d(-0.008 * h, s * 0.103 * h, 0.811 * h);
  at(Joint::forearm_left) = at(Joint::upper_arm_left) + 0.176 * h * out;
  at(Joint::hand_left) = at(Joint::forearm_left) + 0.146 * h * out;
}

}  // namespace

std::string_view to_string(Joint joint) {
  return kNames[index(joint)];
}

Joint parent_of(Joint joint) {
  return kParents[index(joint)];
}

Joint on_side(Joint left_joint, Side side) {
  if (side == Side::left) return left_joint;
  const auto i = index(left_joint);
  return static_cast<Joint>(i + (i < index(Joint::thigh_left) ? 3 : 4));
}

double Skeleton::thigh_length() const {
  return (joint[index(Joint::shank_left)] - joint[index(Joint::thigh_left)]).norm();
}
double Skeleton::shank_length() const {
  return (joint[index(Joint::foot_left)] - joint[index(Joint::shank_left)]).norm();
}

Skeleton make_skeleton(double height) {
  Skeleton skeleton;
  skeleton.height = height;
  skeleton.arm_angle = 45.0 * std::numbers::pi / 180.0;
  skeleton.leg_angle = 7.0 * std::numbers::pi / 180.0;
  auto& joint = skeleton.joint;
  joint[index(Joint::pelvis)] = {0.0, 0.0, 0.545 * height};
  joint[index(Joint::spine)] = {-0.010 * height, 0.0, 0.615 * height};
  joint[index(Joint::chest)] = {-0.014 * height, 0.0, 0.715 * height};
  joint[index(Joint::neck)] = {-0.010 * height, 0.0, 0.842 * height};
  joint[index(Joint::head)] = {0.0, 0.0, 0.890 * height};
  for (const Side side : {Side::left, Side::right}) {
    place_leg(skeleton, side, height);
    place_arm(skeleton, side, height);
  }
  return skeleton;
}

Pose bind_pose(const Skeleton& skeleton) {
  Pose pose;
  pose.pelvis = skeleton.joint[index(Joint::pelvis)];
  pose.rotation.fill(Eigen::Quaterniond::Identity());
  return pose;
}

JointTransforms joint_transforms(const Skeleton& skeleton, const Pose& pose) {
  JointTransforms world_from_joint;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::size_t parent = index(kParents[i]);
    Eigen::Isometry3d& own = world_from_joint[i];
    if (i == parent) {
      own = Eigen::Translation3d(pose.pelvis) * pose.rotation[i];
      continue;
    }
    own =
        world_from_joint[parent] * Eigen::Translation3d(skeleton.joint[i] - skeleton.joint[parent]) * pose.rotation[i];
  }
  for (std::size_t i = 0; i < kJoints; ++i)
    world_from_joint[i] = world_from_joint[i] * Eigen::Translation3d(-skeleton.joint[i]);
  return world_from_joint;
}

std::array<Eigen::Vector3d, kJoints> joint_centres(const Skeleton& skeleton, const Pose& pose) {
  const JointTransforms world_from_bind = joint_transforms(skeleton, pose);
  std::array<Eigen::Vector3d, kJoints> centres;
  for (std::size_t i = 0; i < kJoints; ++i) centres[i] = world_from_bind[i] * skeleton.joint[i];
  return centres;
}

}  // namespace rotunda::simulator
