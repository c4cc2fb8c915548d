#pragma once
// When and where each foot stands: a table of steps from a first stand. Lengths are of a person of 1.75 m, others' in
// proportion to their legs; degrees, seconds, world.
#include <vector>

#include "simulator/people/posture.h"
#include "simulator/people/sole.h"

namespace rotunda::simulator {

struct Step {
  Side side;
  double lift, land;        // the foot is off the floor between
  Eigen::Vector2d to;       // of the ankle over the flat foot
  double yaw = 0.0;         // where the toes point to
  double clearance = 0.06;  // of the arc
  bool free = false;        // in between the leg goes where the posture says
};
// The foot turns on its ball, the heel a little up.
struct Pivot {
  Side side;
  double from, until;
  double yaw;
};
struct FootPlan {
  std::vector<Step> steps;  // of each foot in order of time
  std::vector<Pivot> pivots;
};

// The plan carried out from idle's stand.
class Footwork {
 public:
  Footwork(const Skeleton& skeleton, const FootPlan& plan);
  // `free` is where the leg goes by itself.
  LegPlacement leg(Side side, double seconds, const LegPlacement& free) const;
  double load(Side side, double seconds) const;             // share of the weight, 0 to 1
  Eigen::Vector2d middle(Side side, double seconds) const;  // of the foot's last or next place on the floor

 private:
  struct Stand {
    double from, until;
    FootSpot spot;
    double clearance = 0.0;  // of the step that follows
    bool free = false;
  };
  const Stand& stand_at(Side side, double seconds) const;
  FootSpot spot(Side side, const Stand& stand, double seconds) const;
  LegPlacement standing(Side side, const Stand& stand, double seconds) const;
  LegPlacement stepping(Side side, const Stand& from, const Stand& to, double seconds, const LegPlacement& free) const;

  Sole sole_;
  std::array<std::vector<Stand>, 2> stands_;
  std::vector<Pivot> pivots_;
};

}  // namespace rotunda::simulator
