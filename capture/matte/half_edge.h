#pragma once
// The edge of the live key: a two-colour matte along a rough outline at half size.
#include <opencv2/core.hpp>

#include "capture/matte/half_picture.h"

namespace rotunda::capture {

// `box`, and as far around it as the edge can reach.
cv::Rect half_edge_box(const cv::Rect& box, cv::Size within);

// `inside`: CV_8UC1 of the half picture's size, 255 performer, nothing within the edge's reach of `around` or outside
// of it. Returns alpha, CV_8UC1 of `around`.
cv::Mat half_edge_matte(const HalfPicture& half, const cv::Mat& inside, const cv::Rect& around);

}  // namespace rotunda::capture
