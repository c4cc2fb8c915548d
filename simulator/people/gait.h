#pragma once
// Normal walking on level ground, as on a treadmill: the pelvis stays over the origin and the floor under the stance
// foot runs backwards at `speed`. Sagittal joint angles follow the curves of normal gait (Winter, The Biomechanics and
// Motor Control of Human Gait, 1991, natural cadence; Perry, Gait Analysis, 1992, chapters 3 to 6); the stance leg is
// then closed onto the floor, heel first, flat, then over the ball, by inverse kinematics. The cycle closes exactly.
#include <vector>

#include "simulator/people/skeleton.h"

namespace rotunda::simulator {

struct GaitOptions {
  double period = 1.04;  // seconds a stride: two steps
  double speed = 1.15;   // metres a second
};

// The angles of one leg at a phase of its own stride: 0 and 1 are its heel strike. Radians; flexion is positive.
struct LegAngles {
  double hip = 0.0, knee = 0.0, ankle = 0.0;
};
LegAngles normal_leg_angles(double phase);

inline constexpr double kToeOff = 0.62;  // phase at which stance ends (Perry 1992: 62 % of the cycle)

// Pose at a time; the left heel strikes at 0, the right one half a period later.
Pose gait_pose(const Skeleton& skeleton, double seconds, const GaitOptions& options = {});

struct HeelStrike {
  double seconds;
  Side side;
};
std::vector<HeelStrike> heel_strikes(const GaitOptions& options = {});  // of one period

}  // namespace rotunda::simulator
