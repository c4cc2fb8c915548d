#pragma once
// Has a camera moved since it was calibrated? By the background: what stands still in an earlier picture is looked for
// in a later one; or by a board: how far its corners are from where the calibration puts them.
#include <optional>
#include <vector>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

struct BackgroundShift {
  int features = 0;           // that were found again and agree
  double shift_px = 0.0;      // mean over the picture
  double turn_deg = 0.0;      // about the line of sight
  double deviation_px = 0.0;  // standard deviation of the mean shift
};

// `before` and `now` grey, CV_8UC1, one size (else InvalidInput). People may stand in one of them. Nothing where too
// few features agree: an empty wall, another room.
std::optional<BackgroundShift> background_shift(const cv::Mat& before, const cv::Mat& now);

// A shift worth telling: more than a third of a pixel and than what the features could hide.
bool has_moved(const BackgroundShift& shift);

struct BoardShift {
  int corners = 0;
  double shift_px = 0.0;  // root mean square distance of this camera's corners from where all others put the boards
};
// One a camera of the calibration; 0 corners: it saw no board together with another.
std::vector<BoardShift> board_shifts(std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                                     std::span<const Board> boards);

}  // namespace rotunda::capture
