#pragma once
// The rim of a picture's performer, for looking colours up next to the outline.
#include <opencv2/core.hpp>

#include "capture/matte/matte.h"

namespace rotunda::recon {

// CV_32FC1: pixels from the outline inwards, 0 outside. The picture's border is no outline: a body cut by the frame
// goes on beyond it.
cv::Mat depth_inside(const capture::Matte& matte);

// What a pixel so deep inside counts: 0 up to one pixel from the outline, smoothly 1 from `feather` further in.
double outline_weight(double depth_inside, double feather);

// `rgb` CV_8UC3; `depth_in_matte` CV_32FC1: pixels from the outline inwards, 0 outside. The outermost two pixels, where
// lens and demosaicing mix backdrop in, and what lies outside of them next to the outline take the mean colour of the
// cloth just inside; parts too thin to have an inside keep theirs.
cv::Mat rim_from_inside(const cv::Mat& rgb, const cv::Mat& depth_in_matte);

}  // namespace rotunda::recon
