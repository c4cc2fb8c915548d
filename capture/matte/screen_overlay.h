#pragma once
// The blue-screen meter as a picture, quiet where the screen is good and loud where it is not: in its own colours,
// dimmed, with lines every third of a stop, where its light is within half a stop of the middle between its ends; flat
// blue where it is darker, orange and red where it is brighter; magenta where its colour is weak, striped where it is
// over-exposed; grey what is no screen. Rings with stops mark the brightest and the darkest place. A legend and the
// figures stand below.
#include <opencv2/core.hpp>
#include <string>

#include "capture/matte/screen_meter.h"

namespace rotunda::capture {

struct ScreenPicture {
  cv::Mat rgb;        // CV_8UC3, RGB
  cv::Mat alpha;      // CV_8UC1, the performer's matte; empty without one
  std::string title;  // the camera's name
};

// CV_8UC3, RGB, as wide as the picture. Throws InvalidInput for other types or sizes.
cv::Mat screen_overlay(const ScreenPicture& picture, Backdrop backdrop, const ScreenReading& reading);

}  // namespace rotunda::capture
