#pragma once
// A foot on the floor. Heel down, the sole rolls over its rounded back without slipping; heel up, it turns about the
// ball and the toes stay flat. Metres, radians, world.
#include "simulator/people/limb_pose.h"

namespace rotunda::simulator {

// Where a foot stands, by the ball: what stays put when the heel lifts and when the foot turns on the spot.
struct FootSpot {
  Eigen::Vector2d ball = Eigen::Vector2d::Zero();
  double yaw = 0.0;  // where the toes point to
};

class Sole {
 public:
  explicit Sole(const Skeleton& skeleton);
  // The spot of a flat foot whose ankle is above a point.
  FootSpot spot_at(const Eigen::Vector2d& ankle, double yaw) const;
  Eigen::Vector2d flat_ankle(const FootSpot& spot) const;
  // The leg's end of a foot that stands there; pitch: toes up, against the floor.
  LegPlacement standing(const FootSpot& spot, double pitch) const;
  // Of a flat foot's ankle at x = 0, the ankle's (x, z) at a pitch.
  Eigen::Vector2d ankle_at(double pitch) const;
  // Lifts a foot until heel, ball and toe tip are at least `clearance` above where they are on the floor.
  void lift_over_floor(LegPlacement& leg, double clearance) const;

 private:
  // The back of the sole in the sagittal plane: an ellipse (body_parts.cpp), from the ankle.
  double heel_parameter(double pitch) const;
  double heel_arc(double pitch) const;

  double ankle_height_;
  Eigen::Vector2d ball_;         // from the flat foot's ankle, z from the floor
  Eigen::Vector2d heel_centre_;  // from the ankle
  double a_, b_, scale_;
};

// The frame of a foot with this yaw and pitch, world from the bind pose.
Eigen::Quaterniond foot_frame(double yaw, double pitch);

}  // namespace rotunda::simulator
