#pragma once
// The skeleton of a BodyTemplate: nineteen joints, what moves in each and how far. Metres, z up. At rest the person
// faces +x with the left side at +y, legs straight down, arms stretched out sideways (a T-pose), and every joint's
// frame is parallel to the world's, so a Pose is a rotation a joint away from that. Ranges of motion: healthy adults
// after Greene, Heckman: The Clinical Measurement of Joint Motion (1994), widened by 15 degrees, for acrobats and
// dancers are people too.
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace rotunda::recon {

// Parents come before their children.
enum class BodyJoint : std::uint8_t {
  pelvis,
  spine,
  chest,
  neck,
  head,
  clavicle_left,
  upper_arm_left,
  forearm_left,
  hand_left,
  clavicle_right,
  upper_arm_right,
  forearm_right,
  hand_right,
  thigh_left,
  shank_left,
  foot_left,
  thigh_right,
  shank_right,
  foot_right,
};
inline constexpr std::size_t kBodyJoints = 19;
constexpr std::size_t index(BodyJoint joint) {
  return static_cast<std::size_t>(joint);
}
constexpr BodyJoint body_joint(std::size_t index) {
  return static_cast<BodyJoint>(index);
}
std::string_view to_string(BodyJoint joint);
std::optional<BodyJoint> parent_of(BodyJoint joint);  // of the pelvis: nothing
BodyJoint mirrored(BodyJoint joint);                  // the same joint of the other side; of the trunk the joint itself

// What a joint can do. `free`: all (the root). `ball`: any rotation within limits. `hinge`: about one axis of its
// parent. `hinge_and_twist`: that, then about its own bone (elbow and forearm). `rigid`: nothing.
enum class JointMotion : std::uint8_t { free, ball, hinge, hinge_and_twist, rigid };

// Where a rotation q lies in its range: for balls q = centre * swing * twist, the coordinates are the swing's rotation
// vector (across the bone) plus the twist's angle times `bone`; for hinges q = turn about `hinge` * twist, and they are
// the turn's angle times `hinge` plus the twist's times `bone`. Radians, component by component between `low` and
// `high`.
struct JointRange {
  JointMotion motion = JointMotion::rigid;
  Eigen::Vector3d bone = Eigen::Vector3d::UnitZ();   // along the bone, unit, joint's frame
  Eigen::Vector3d hinge = Eigen::Vector3d::UnitX();  // unit, parent's frame; hinges only
  Eigen::Quaterniond centre = Eigen::Quaterniond::Identity();
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
};
const JointRange& range_of(BodyJoint joint);

Eigen::Vector3d range_coordinates(const JointRange& range, const Eigen::Quaterniond& rotation);
Eigen::Quaterniond rotation_at(const JointRange& range, const Eigen::Vector3d& coordinates);  // the inverse

struct Skeleton {
  std::array<Eigen::Vector3d, kBodyJoints> offset;  // of a joint from its parent at rest; of the pelvis zero
  Eigen::Vector3d crown;                            // top of the head from the head joint, at rest
  Eigen::Vector3d fingertip;  // of the left hand from its joint, at rest; the right one's mirrors it
  Eigen::Vector3d toe;        // tip of a foot from its joint, at rest
  double leg_length() const;  // hip to ankle
};

}  // namespace rotunda::recon
