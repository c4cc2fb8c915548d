#pragma once
// Limbs put where they should be: legs by two-bone inverse kinematics, arms by shoulder and elbow angles. Metres,
// radians, world.
#include "simulator/people/skeleton.h"

namespace rotunda::simulator {

struct FootPlacement {
  Eigen::Vector3d ankle = Eigen::Vector3d::Zero();  // in world
  double pitch = 0.0;                               // toes up, against the floor
  double toe_out = 0.0;                             // the foot's turn outwards
  double toe_bend = 0.0;                            // of the toes against the foot, upwards
};

// Turns thigh, shank, foot and toes of `pose` so that the ankle comes to its place (as near as the leg reaches), the
// knee bends forwards. The pelvis must be in place.
void place_foot(const Skeleton& skeleton, Pose& pose, Side side, const FootPlacement& foot);

// The height of the ankle above the sole in the bind pose.
double ankle_height(const Skeleton& skeleton);

struct ArmAngles {
  double abduction = 0.0;  // from hanging, outwards
  double flexion = 0.0;    // from hanging, forwards
  double elbow = 0.0;      // 0 straight
};
void place_arm(const Skeleton& skeleton, Pose& pose, Side side, const ArmAngles& arm);

// Bend of the knee in a pose, 0 straight.
double knee_flexion(const Pose& pose, Side side);

}  // namespace rotunda::simulator
