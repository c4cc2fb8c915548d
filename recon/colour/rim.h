#pragma once
// The rim of a picture's performer, for looking colours up next to the outline.
#include <opencv2/core.hpp>

namespace rotunda::recon {

// `rgb` CV_8UC3; `depth_in_matte` CV_32FC1: pixels from the outline inwards, 0 outside. The outermost two pixels, where
// lens and demosaicing mix backdrop in, and what lies outside of them next to the outline take the mean colour of the
// cloth just inside; parts too thin to have an inside keep theirs.
cv::Mat rim_from_inside(const cv::Mat& rgb, const cv::Mat& depth_in_matte);

}  // namespace rotunda::recon
