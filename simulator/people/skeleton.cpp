#include "simulator/people/skeleton.h"

#include <cmath>
#include <numbers>

namespace rotunda::simulator {
namespace {

struct JointRow {
  std::string_view name;
  Joint parent;
};
using enum Joint;

constexpr std::array<JointRow, kJoints> kJointTable = {{
    {"pelvis", pelvis},
    {"spine", pelvis},
    {"chest", spine},
    {"neck", chest},
    {"head", neck},
    {"clavicle_left", chest},
    {"upper_arm_left", clavicle_left},
    {"forearm_left", upper_arm_left},
    {"hand_left", forearm_left},
    {"thumb1_left", hand_left},
    {"thumb2_left", thumb1_left},
    {"index1_left", hand_left},
    {"index2_left", index1_left},
    {"middle1_left", hand_left},
    {"middle2_left", middle1_left},
    {"ring1_left", hand_left},
    {"ring2_left", ring1_left},
    {"little1_left", hand_left},
    {"little2_left", little1_left},
    {"clavicle_right", chest},
    {"upper_arm_right", clavicle_right},
    {"forearm_right", upper_arm_right},
    {"hand_right", forearm_right},
    {"thumb1_right", hand_right},
    {"thumb2_right", thumb1_right},
    {"index1_right", hand_right},
    {"index2_right", index1_right},
    {"middle1_right", hand_right},
    {"middle2_right", middle1_right},
    {"ring1_right", hand_right},
    {"ring2_right", ring1_right},
    {"little1_right", hand_right},
    {"little2_right", little1_right},
    {"thigh_left", pelvis},
    {"shank_left", thigh_left},
    {"foot_left", shank_left},
    {"toes_left", foot_left},
    {"thigh_right", pelvis},
    {"shank_right", thigh_right},
    {"foot_right", shank_right},
    {"toes_right", foot_right},
}};

void place_leg(Skeleton& skeleton, Side side, double h, const Proportions& proportions) {
  const double s = sign_of(side);
  const Eigen::Vector3d down(0.0, s * std::sin(skeleton.leg_angle), -std::cos(skeleton.leg_angle));
  auto& joint = skeleton.joint;
  const auto at = [&](Joint left) -> Eigen::Vector3d& { return joint[index(on_side(left, side))]; };
  at(Joint::thigh_left) =
      Eigen::Vector3d(0.0, s * 0.0525 * h * proportions.hips, (0.050 + 0.485 * proportions.legs) * h);
  at(Joint::shank_left) = at(Joint::thigh_left) + 0.245 * h * proportions.legs * down;
  at(Joint::foot_left) = at(Joint::shank_left) + 0.240 * h * proportions.legs * down;
  at(Joint::toes_left) = at(Joint::foot_left) + Eigen::Vector3d(0.077 * h, 0.0, 0.0);
  at(Joint::toes_left).z() = 0.016 * h;
}

void place_arm(Skeleton& skeleton, Side side, double h, const Proportions& proportions) {
  const double s = sign_of(side);
  const Eigen::Vector3d out(0.0, s * std::sin(skeleton.arm_angle), -std::cos(skeleton.arm_angle));
  auto& joint = skeleton.joint;
  const auto at = [&](Joint left) -> Eigen::Vector3d& { return joint[index(on_side(left, side))]; };
  at(Joint::clavicle_left) = Eigen::Vector3d(-0.004 * h, s * 0.018 * h, 0.815 * h);
  at(Joint::upper_arm_left) = Eigen::Vector3d(-0.008 * h, s * 0.103 * h * proportions.shoulders, 0.811 * h);
  at(Joint::forearm_left) = at(Joint::upper_arm_left) + 0.176 * h * proportions.arms * out;
  at(Joint::hand_left) = at(Joint::forearm_left) + 0.146 * h * proportions.arms * out;
}

// Knuckles and next joints of the stretched hand, from the wrist: along the hand, and across it towards the thumb;
// metres at 1.75 m (Buchholz, Armstrong, Goldstein 1992: segment lengths as fractions of the hand's).
struct FingerRow {
  Joint first;
  double along, across, next_along, next_across;
};
constexpr std::array<FingerRow, 5> kFingers = {{{thumb1_left, 0.028, 0.022, 0.065, 0.050},
                                                {index1_left, 0.088, 0.028, 0.130, 0.036},
                                                {middle1_left, 0.091, 0.009, 0.137, 0.012},
                                                {ring1_left, 0.087, -0.010, 0.130, -0.013},
                                                {little1_left, 0.080, -0.028, 0.113, -0.037}}};

void place_fingers(Skeleton& skeleton, Side side, double h) {
  auto& joint = skeleton.joint;
  const auto at = [&](Joint left) -> Eigen::Vector3d& { return joint[index(on_side(left, side))]; };
  const Eigen::Vector3d wrist = at(hand_left), out = (wrist - at(forearm_left)).normalized();
  const double scale = h / 1.75;
  for (const auto& row : kFingers) {
    const auto next = static_cast<Joint>(index(row.first) + 1);
    at(row.first) = wrist + scale * (row.along * out + row.across * Eigen::Vector3d::UnitX());
    at(next) = wrist + scale * (row.next_along * out + row.next_across * Eigen::Vector3d::UnitX());
  }
}

}  // namespace

std::string_view to_string(Joint joint) {
  return kJointTable[index(joint)].name;
}

Joint parent_of(Joint joint) {
  return kJointTable[index(joint)].parent;
}

Joint on_side(Joint left_joint, Side side) {
  if (side == Side::left) return left_joint;
  const std::size_t block = left_joint < Joint::thigh_left ? index(Joint::clavicle_right) - index(Joint::clavicle_left)
                                                           : index(Joint::thigh_right) - index(Joint::thigh_left);
  return static_cast<Joint>(index(left_joint) + block);
}

double Skeleton::thigh_length() const {
  return (joint[index(Joint::shank_left)] - joint[index(Joint::thigh_left)]).norm();
}
double Skeleton::shank_length() const {
  return (joint[index(Joint::foot_left)] - joint[index(Joint::shank_left)]).norm();
}

Skeleton make_skeleton(double height, const Proportions& proportions) {
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
    place_leg(skeleton, side, height, proportions);
    place_arm(skeleton, side, height, proportions);
    place_fingers(skeleton, side, height);
  }
  return skeleton;
}

Pose bind_pose(const Skeleton& skeleton) {
  Pose pose;
  pose.pelvis = skeleton.joint[index(Joint::pelvis)];
  pose.rotation.fill(Eigen::Quaterniond::Identity());
  return pose;
}

void curl_fingers(Pose& pose, Side side, double curl) {
  constexpr double kRelaxed = 18.0 * std::numbers::pi / 180.0;
  // In the bind pose the palm faces the body and the fingers run along the arm: they close about the body's forward
  // axis.
  const Eigen::Quaterniond close(Eigen::AngleAxisd(-sign_of(side) * kRelaxed * curl, Eigen::Vector3d::UnitX()));
  for (std::size_t i = index(on_side(index1_left, side)); i <= index(on_side(little2_left, side)); ++i)
    pose.rotation[i] = close;
}

JointTransforms joint_transforms(const Skeleton& skeleton, const Pose& pose) {
  JointTransforms world_from_joint;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::size_t parent = index(kJointTable[i].parent);
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
