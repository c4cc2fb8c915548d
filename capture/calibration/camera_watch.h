#pragma once
// Has a camera moved since it was calibrated? By the background: what stands still in an earlier picture is looked for
// in a later one. By a board: board_watch.h.
#include <opencv2/core.hpp>
#include <optional>

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

}  // namespace rotunda::capture
