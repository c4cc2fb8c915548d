#pragma once
// Limbs put where they should be: by joint angles, or by two-bone inverse kinematics with the knee (the elbow) pointing
// where it is told. Metres, radians, world. The trunk must be in place.
#include <array>
#include <optional>

#include "simulator/people/skeleton.h"

namespace rotunda::simulator {

struct LegPlacement {
  Eigen::Vector3d ankle = Eigen::Vector3d::Zero();
  Eigen::Quaterniond foot = Eigen::Quaterniond::Identity();  // world from the bind pose
  Eigen::Vector3d knee = Eigen::Vector3d::UnitX();           // direction in which the knee points
  double toe_bend = 0.0;                                     // of the toes against the foot, upwards
  double slack = 0.0;  // how far the ankle may stay out of reach; the standing foot's is 0
};

// All 0: the leg hangs straight down from the pelvis.
struct LegAngles {
  double hip = 0.0, abduction = 0.0, rotation = 0.0;  // forwards; outwards; toes outwards
  double knee = 0.0, ankle = 0.0;                     // flexion; toes up
};

// All 0: the arm hangs straight down from the chest, palm to the thigh.
struct ArmAngles {
  double abduction = 0.0, flexion = 0.0, rotation = 0.0;  // outwards; forwards; inwards, about the upper arm
  double elbow = 0.0, pronation = 0.0, wrist = 0.0;       // flexion; thumb inwards; flexion to the palm
};

struct HandPlacement {
  Eigen::Vector3d wrist = Eigen::Vector3d::Zero();
  Eigen::Quaterniond hand = Eigen::Quaterniond::Identity();  // world from the bind pose
  Eigen::Vector3d elbow = -Eigen::Vector3d::UnitX();         // direction in which the elbow points
};

// Where a leg with these angles has its foot.
LegPlacement leg_with(const Skeleton& skeleton, const Pose& pose, Side side, const LegAngles& angles);
void place_leg(const Skeleton& skeleton, Pose& pose, Side side, const LegPlacement& leg);

void place_arm(const Skeleton& skeleton, Pose& pose, Side side, const ArmAngles& angles);
HandPlacement hand_of(const Skeleton& skeleton, const Pose& pose, Side side);  // where the hand is
void place_hand(const Skeleton& skeleton, Pose& pose, Side side, const HandPlacement& hand);

// The hand's frame against its bind pose when the fingers point to `along` and the palm looks to `palm`.
Eigen::Quaterniond hand_towards(const Skeleton& skeleton, Side side, const Eigen::Vector3d& along,
                                const Eigen::Vector3d& palm);

// The pelvis no higher than both legs reach their ankles, knees never quite straight; smooth in everything.
double reachable_pelvis_height(const Skeleton& skeleton, const Pose& pose, const std::array<LegPlacement, 2>& legs);

double ankle_height(const Skeleton& skeleton);  // above the sole in the bind pose
// Lengths in acts are of this much of a person: 1 for the one of 1.75 m.
double leg_scale(const Skeleton& skeleton);

// Bends of a pose, 0 straight; negative would be backwards.
double knee_flexion(const Skeleton& skeleton, const Pose& pose, Side side);
double elbow_flexion(const Skeleton& skeleton, const Pose& pose, Side side);

}  // namespace rotunda::simulator
