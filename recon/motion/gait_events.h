#pragma once
// What the feet do, from the surfaces of a clip alone (ALGORITHMS step 9): which way the person faces, how the floor
// runs under them (a treadmill's belt; people who go on the spot), when heels strike and which foot stands when.
// Heel strikes of people who walk or run: the foot is farthest ahead of the body (Zeni, Richards, Higginson 2008), then
// first down. Of people who stay: a lifted foot stands flat again. World frame, metres, seconds. Lattice samples need
// not correspond over time.
#include <Eigen/Core>
#include <vector>

#include "recon/motion/clip_shape.h"

namespace rotunda::recon {

enum class Side { left, right };

struct HeelStrike {
  int frame = 0;
  Side side = Side::left;
  bool operator==(const HeelStrike&) const = default;
};

// A foot that stands on the floor, in the frames begin to end - 1.
struct FootContact {
  int begin = 0, end = 0;
  Side side = Side::left;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  // where it stands, on the floor that the clip travels over
};

struct GaitEvents {
  double floor_height = 0.0;
  double height = 0.0;                                       // of the person, metres: the tallest frame
  Eigen::Vector2d floor_velocity = Eigen::Vector2d::Zero();  // m/s; zero where the floor stands
  double heading = 0.0;               // the way the person goes or, standing, faces; about +z from +x
  double speed = 0.0;                 // mean over the floor, m/s
  std::vector<HeelStrike> strikes;    // in order
  std::vector<FootContact> contacts;  // in order of their begin
};

GaitEvents gait_events(const ClipShape& clip);

// The clip over a floor that stands: what the belt carried back is put forward again.
void travel(ClipShape& clip, const GaitEvents& events);

}  // namespace rotunda::recon
