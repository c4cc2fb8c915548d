#pragma once
// An act as a table: key postures, steps, hands put on the floor. Between the keys everything runs on smooth curves;
// the weight goes over the standing feet as that of an inverted pendulum must (Kajita et al., "The 3D linear inverted
// pendulum mode", 2001): it moves before the foot lifts. Begins and ends in idle's stand. Metres of a person of 1.75 m,
// degrees, seconds.
#include <functional>
#include <vector>

#include "simulator/people/act.h"
#include "simulator/people/foot_plan.h"

namespace rotunda::simulator {

struct PostureKey {
  double seconds;
  Posture posture;
};
// A palm flat on the floor, fingers towards yaw.
struct HandPlant {
  Side side;
  double from, until;
  Eigen::Vector2d at;
  double yaw = 0.0;
};
// A hand on something that moves by itself.
struct HandHold {
  HandPlacement hand;
  double share = 0.0;              // 0: the hand is where the posture says, 1: it holds
  double curl = 1.0, thumb = 0.0;  // of the fingers (curl_fingers); of the thumb towards the palm, radians
};
struct KeyedMotion {
  std::string name;
  int frames = 1;
  std::vector<PostureKey> keys;  // in order of time; the first and last are idle's
  FootPlan feet;
  std::vector<HandPlant> hands;
  std::function<HandHold(Side, double seconds)> holds;  // if there is something to hold
};

// Throws nothing; the table is the program's own.
Motion keyed_motion(const Skeleton& skeleton, const KeyedMotion& table, std::uint32_t seed);

// Of all segments, masses and centres of de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters",
// 1996.
Eigen::Vector3d centre_of_mass(const Skeleton& skeleton, const Pose& pose);

}  // namespace rotunda::simulator
