#pragma once
// The blue-screen meter: how good a backdrop one camera sees, for whoever sets the lights. Measured on a picture of the
// empty studio or one with a performer before the screen.
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/matte/backdrop_plate.h"

namespace rotunda::capture {

struct ScreenReading {
  double share = 0.0;       // of the picture that is screen, 0 to 1
  double unevenness = 1.0;  // brightest to darkest part of the screen (95th to 5th percentile of the backdrop's channel
                            // in linear light): 1 even, 2 a stop
  double saturation = 0.0;  // 1 - the larger of the other channels / the backdrop's, linear light: median of the screen
  double least_saturation = 0.0;  // its 5th percentile
  double clipped = 0.0;           // share of the screen whose backdrop channel is at its end
  double noise = 0.0;             // of the backdrop's channel, standard deviation in grey levels
  double headroom = 0.0;          // how many standard deviations of noise lie between the screen and what the key calls
                                  // performer, where it is tightest (5th percentile); below 4 the matte gets specks
  std::optional<double> spill;  // of the backdrop's colour on the performer's rim beyond that of the cloth inside, grey
                                // levels, mean; none without a performer
  std::string brightest, darkest;   // where, as "upper left"; empty if it is even
  std::vector<std::string> advice;  // what to do, a sentence each; empty if it is good
};

// `pictures` (CV_8UC3, RGB) of one camera, one after the other: the first is measured, the others tell its noise; with
// one alone noise is taken from its own finest detail. `alpha` (CV_8UC1) is the first one's matte, empty without a
// performer. Throws InvalidInput without pictures or for sizes and types that differ.
ScreenReading measure_screen(std::span<const cv::Mat> pictures, Backdrop backdrop, const cv::Mat& alpha = {});

}  // namespace rotunda::capture
