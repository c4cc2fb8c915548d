#pragma once
// How everybody stands when nothing is asked of them: what acts begin with and end in.
#include "simulator/people/gait.h"

namespace rotunda::simulator::acts {

inline constexpr int kIdleFrames = 100;  // of kActStep, one breath

// Seconds of idle, any: it repeats. Small, slow and never quite the same with another seed: breath, sway, glances.
Posture idle_posture(double seconds, std::uint32_t seed);

// Both feet on idle's spots, the pelvis over x.
std::array<LegPlacement, 2> idle_legs(const Skeleton& skeleton, double x = 0.0);

// The pose of a posture on its feet whose pelvis belongs over (x, y); the posture's forward and left are added.
Pose standing_pose(const Skeleton& skeleton, const Posture& posture, const Eigen::Vector2d& place,
                   const std::array<LegPlacement, 2>& legs);

}  // namespace rotunda::simulator::acts
