#pragma once
// Spill: light off the backdrop on the performer's rim. Taken out only where the evidence is: near the outline, and
// only as far as the rim leads the cloth just inside of it in the backdrop's colour, so blue clothes stay blue.
#include <opencv2/core.hpp>

#include "capture/matte/backdrop_plate.h"

namespace rotunda::recon {

// `rgb` CV_8UC3; `depth_in_matte` CV_32FC1: pixels from the outline inwards, 0 outside.
cv::Mat without_spill(const cv::Mat& rgb, const cv::Mat& depth_in_matte, capture::Backdrop backdrop);

// The outermost two pixels, where lens and demosaicing mix backdrop in, and what lies outside of them next to the
// outline take the mean colour of the cloth just inside; parts too thin to have an inside keep theirs.
cv::Mat rim_from_inside(const cv::Mat& rgb, const cv::Mat& depth_in_matte);

}  // namespace rotunda::recon
