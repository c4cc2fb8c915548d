#pragma once
// What an operator wants to know of a camera's picture at a glance: is it over-exposed, is it in focus.
#include <opencv2/core.hpp>

namespace rotunda::capture {

struct PictureHealth {
  double clipped = 0.0;  // share of pixels with a channel at its end, 0 .. 1
  double focus = 0.0;    // 0 .. 1: how much of the finest detail that the pixels could hold is there
};

// Of an RGB picture (CV_8UC3). Focus compares green's differences over 2 pixels with those over 8: across sharp edges
// their squares grow in proportion to the distance, across blurred ones with its square. Noise, estimated from the
// picture, is taken off, so neither contrast nor gain tells much; a picture without detail has focus 0.
PictureHealth picture_health(const cv::Mat& rgb);

}  // namespace rotunda::capture
