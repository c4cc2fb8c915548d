#pragma once
// The skeleton of a simulated person. Person frame: metres, x forward, y to the left, z up, origin on the floor. In the
// bind pose (an A-pose) every joint's frame is parallel to the person's, so a pose is a rotation a joint away from it.
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace rotunda::simulator {

// Parents come before their children. A finger has two joints: the knuckle and the next one (the last follows it).
enum class Joint : std::uint8_t {
  pelvis,
  spine,
  chest,
  neck,
  head,
  clavicle_left,
  upper_arm_left,
  forearm_left,
  hand_left,
  thumb1_left,
  thumb2_left,
  index1_left,
  index2_left,
  middle1_left,
  middle2_left,
  ring1_left,
  ring2_left,
  little1_left,
  little2_left,
  clavicle_right,
  upper_arm_right,
  forearm_right,
  hand_right,
  thumb1_right,
  thumb2_right,
  index1_right,
  index2_right,
  middle1_right,
  middle2_right,
  ring1_right,
  ring2_right,
  little1_right,
  little2_right,
  thigh_left,
  shank_left,
  foot_left,
  toes_left,
  thigh_right,
  shank_right,
  foot_right,
  toes_right,
};
inline constexpr std::size_t kJoints = 41;
constexpr std::size_t index(Joint joint) {
  return static_cast<std::size_t>(joint);
}
std::string_view to_string(Joint joint);
Joint parent_of(Joint joint);  // the pelvis is its own parent

enum class Side { left, right };
// +1 for left, -1 for right: the sign of y.
constexpr double sign_of(Side side) {
  return side == Side::left ? 1.0 : -1.0;
}
// The joint of a limb on a side, given the left one.
Joint on_side(Joint left_joint, Side side);

struct Skeleton {
  double height = 1.75;                        // metres, in shoes
  double arm_angle = 0.0, leg_angle = 0.0;     // of the bind pose, from straight down, outwards, radians
  std::array<Eigen::Vector3d, kJoints> joint;  // centres in the bind pose
  double thigh_length() const;
  double shank_length() const;
};

// Breadths and lengths against the table's.
struct Proportions {
  double shoulders = 1.0, hips = 1.0;  // breadths between the joints
  double legs = 1.0, arms = 1.0;       // lengths
};

// Segment lengths as fractions of the height after Drillis and Contini (1966), as printed in Winter, Biomechanics and
// Motor Control of Human Movement, figure 4.1; shoes add the sole.
Skeleton make_skeleton(double height, const Proportions& proportions = {});

struct Pose {
  Eigen::Vector3d pelvis = Eigen::Vector3d::Zero();  // where the pelvis joint is, metres, world
  std::array<Eigen::Quaterniond, kJoints> rotation;  // of a joint's frame in its parent's; identity: bind pose
};
Pose bind_pose(const Skeleton& skeleton);

// Bends the four fingers of a hand towards its palm: 0 stretched, 1 as they hang by themselves, about 4 a fist.
void curl_fingers(Pose& pose, Side side, double curl);

// world_from_bind of every joint: what carries a point of the bind pose along with that joint.
using JointTransforms = std::array<Eigen::Isometry3d, kJoints>;
JointTransforms joint_transforms(const Skeleton& skeleton, const Pose& pose);

// Joint centres in world.
std::array<Eigen::Vector3d, kJoints> joint_centres(const Skeleton& skeleton, const Pose& pose);

}  // namespace rotunda::simulator
