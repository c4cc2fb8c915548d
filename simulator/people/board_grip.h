#pragma once
// Hands on a carried plate: the palms at the middles of its left and right edges, fingers hooked over its face, thumbs
// behind it; when it lies down the hands hold it between their fingers' ends. Metres, world.
#include "simulator/people/board_act.h"
#include "simulator/people/keyed_motion.h"

namespace rotunda::simulator {

// The edge's point a hand holds, board frame. The left hand has the plate's right edge: its face looks away from them.
Eigen::Vector3d held_point(const CarriedBoard& plate, Side side);

// Where that point is against the hand, in the hand's bind pose: how well a pose holds the plate. `flat`: 0 as it is
// carried, 1 as it lies.
Eigen::Vector3d holding_point(const Skeleton& skeleton, Side side, double flat);

struct GripOptions {
  double heading = 0.0;  // of the body, radians
  double apart = 0.0;    // of the hands from the edges, metres
};
HandHold grip(const Skeleton& skeleton, Side side, const Eigen::Isometry3d& world_from_board,
              const GripOptions& options, const CarriedBoard& plate = {});
// How far the hands have gone from the carrying hold to the laying one, 0 to 1.
double flatness_of_grip(const Skeleton& skeleton, const Eigen::Isometry3d& world_from_board);

}  // namespace rotunda::simulator
