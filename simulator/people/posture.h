#pragma once
// A posture in anatomical terms: what the tables of the acts are written in. Degrees, and metres of a person of 1.75 m
// (others in proportion to their legs). Zero everywhere: upright, limbs hanging straight. Plain numbers, so postures
// can be blended and put on curves.
#include <array>
#include <cstddef>

#include "simulator/people/limb_pose.h"

namespace rotunda::simulator {

constexpr std::size_t at(Side side) {
  return side == Side::left ? 0 : 1;
}
constexpr Side other(Side side) {
  return side == Side::left ? Side::right : Side::left;
}
constexpr double radians(double degrees) {
  return degrees * 3.14159265358979323846 / 180.0;
}

struct ArmPosture {
  double abduction = 13.0, flexion = 1.0, rotation = 8.0;  // outwards, forwards, inwards
  double elbow = 15.0, pronation = 10.0, wrist = 6.0;
  double curl = 32.0;  // of the fingers' middle joints
  double shrug = 0.0;  // of the shoulder, upwards
};

// Counts only while the foot is off the floor.
struct LegPosture {
  double hip = 0.0, abduction = 4.0, rotation = 6.0;  // forwards, outwards, toes outwards
  double knee = 10.0, ankle = 0.0;                    // flexion, toes up
};

struct Posture {
  double forward = 0.0, left = 0.0, height = 0.0;   // of the pelvis from its place, in its heading
  double yaw = 0.0, list = 0.0, tilt = 0.0;         // of the pelvis: to the left (its heading), to the right, forwards
  double twist = 0.0, side_bend = 0.0, bend = 0.0;  // of the trunk against the pelvis: same senses
  double look = 0.0, head_tilt = 0.0, nod = 0.0;    // of the head against the heading: same senses
  std::array<ArmPosture, 2> arm;
  std::array<LegPosture, 2> leg;

  ArmPosture& arm_of(Side side) { return arm[at(side)]; }
  LegPosture& leg_of(Side side) { return leg[at(side)]; }
};

inline constexpr std::size_t kPostureValues = sizeof(Posture) / sizeof(double);
using PostureValues = std::array<double, kPostureValues>;
PostureValues values_of(const Posture& posture);
Posture posture_of(const PostureValues& values);

Posture blend(const Posture& from, const Posture& to, double weight);
Posture mirrored(const Posture& posture);  // left for right

// Height of the pelvis of one who stands straight, metres.
double standing_height(const Skeleton& skeleton);

// Pelvis, trunk, head and arms as the posture says; legs as in the bind pose. The head keeps upright and steady over a
// trunk that moves, until the body tips over as a whole.
Pose trunk_pose(const Skeleton& skeleton, const Posture& posture, const Eigen::Vector3d& pelvis);

// Both legs onto their places, the pelvis let down as far as they need.
void stand_on(const Skeleton& skeleton, Pose& pose, const std::array<LegPlacement, 2>& legs);

}  // namespace rotunda::simulator
