#pragma once
// Both feet of a clip, frame by frame: the surface's lowest parts that are joined only higher up. Private to
// recon/motion. World, metres. Which of the two is the left one is not known here.
#include <array>
#include <vector>

#include "recon/motion/clip_shape.h"

namespace rotunda::recon {

struct FootState {
  bool seen = false;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  // middle of its lowest part
  Eigen::Vector2d ankle = Eigen::Vector2d::Zero();
  double height = 0.0;  // of its lowest point above the floor
  double sole = 0.0;    // m^2 of it within 3 cm of the floor
};

struct FootTracks {
  double floor_height = 0.0, person_height = 0.0;
  std::array<std::vector<FootState>, 2> feet;  // a state a frame
};

FootTracks track_feet(const ClipShape& clip);

}  // namespace rotunda::recon
