#pragma once
// The edge of the live key: a two-colour matte along a rough outline at half size, brought up to the picture's size.
#include <opencv2/core.hpp>

#include "capture/matte/half_picture.h"

namespace rotunda::capture {

// `inside`: CV_8UC1 of the half picture's size, 255 performer, nothing outside of `box`; `size`: the whole picture's.
// Returns alpha, CV_8UC1 of that size.
cv::Mat half_edge_matte(const HalfPicture& half, const cv::Mat& inside, const cv::Rect& box, cv::Size size);

}  // namespace rotunda::capture
