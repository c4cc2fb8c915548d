#pragma once
// The act `board`: a person carries a rigid calibration board through the whole volume, into each of its corners high
// and low, tilted, with its face to every side, lays it on the floor at the middle, face up, and steps back. The
// board's path is the same for everybody; the person follows it with both hands. World: metres, z up.
#include <Eigen/Geometry>

namespace rotunda::simulator {

// The rigid plate, held at the middles of its left and right edges.
struct CarriedBoard {
  double width = 0.66, height = 0.46;  // of the whole plate: squares of 100 mm, 6 by 4, and a margin of 30 mm
  double thickness = 0.010;
};

inline constexpr int kBoardActFrames = 830;        // of kActStep
inline constexpr double kBoardLaidSeconds = 29.8;  // from here on the board lies on the floor

// world_from_board at a time of the act. Board frame: origin at the middle of the printed face, x to the right and y up
// as one reads it, z out of the face. At the end the face lies at z = thickness.
Eigen::Isometry3d board_pose(double seconds);
// Where the face looks to from above, degrees from +x, counter-clockwise, running on over whole turns.
double board_facing(double seconds);

}  // namespace rotunda::simulator
