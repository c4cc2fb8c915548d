#pragma once
// Has a camera moved since it was calibrated? By a board: how far its corners are from where the others put them. The
// board stands wherever somebody holds it, so a camera that was knocked drags the boards of its neighbours along: those
// are the moved ones without which the rest agrees, and as few as will do.
#include <span>
#include <vector>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

struct BoardShift {
  int corners = 0;
  double shift_px = 0.0;  // root mean square distance of this camera's corners from where the unmoved others put them
  bool moved = false;
  bool disputed = false;  // it disagrees with one other camera, and no third says which of the two moved
};

struct BoardWatchOptions {
  double told_px = 1.0;   // a shift; boards held by hand and the calibration itself make a few tenths
  double agree_px = 0.5;  // root mean square residual of two cameras that both stand still
};

// One a camera of the calibration; 0 corners: it saw no board together with an unmoved other. A shift that two cameras
// cannot see, because each alone could place the board so, is not told.
std::vector<BoardShift> board_shifts(std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                                     std::span<const Board> boards, const BoardWatchOptions& options = {});

}  // namespace rotunda::capture
