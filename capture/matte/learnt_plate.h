#pragma once
// The empty studio learnt from a take, for want of a picture of it: every pixel of the backdrop is uncovered sooner or
// later. Pictures from all over the take are keyed against a smooth surface through each one's own backdrop; what is
// well clear of the performer is brought to one light, and of each pixel's values those without shadow are averaged.
// What nobody ever uncovers is filled: the smooth surface, shifted as the learnt pixels about it are. Lamps that are
// white in nearly all pictures are left as they are.
// Things on the backdrop that are not of its colour, as white tape, stay performer: nothing tells them from a shoe.
#include <opencv2/core.hpp>
#include <span>

#include "capture/matte/backdrop_plate.h"

namespace rotunda::capture {

struct LearntPlate {
  cv::Mat picture;         // CV_8UC3, RGB; empty if fewer than kFewestPlatePictures show the backdrop
  double uncovered = 0.0;  // share of the pixels that were learnt, not filled
};

inline constexpr std::size_t kFewestPlatePictures = 4;

// `pictures`: one camera's, CV_8UC3, RGB, in the order of time. The plate is in the light of their middle.
// Throws InvalidInput if their sizes or types differ.
LearntPlate learn_plate(std::span<const cv::Mat> pictures, Backdrop backdrop);

}  // namespace rotunda::capture
