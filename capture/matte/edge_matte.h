#pragma once
// The local two-colour matte: in a band about a rough outline, how much of each pixel is performer.
#include <opencv2/core.hpp>

#include "capture/matte/matte.h"

namespace rotunda::capture {

// `rgb` CV_8UC3 and `plate` CV_8UC3, both sRGB; `inside` CV_8UC1, 255 where the rough outline says performer.
// `firm` likewise where a pixel cannot be a mixture: a gap between limbs that the rough outline has closed is looked at
// too. Alpha is 255 or 0 outside of the band (3 px to either side).
Matte edge_matte(const cv::Mat& rgb, const cv::Mat& plate, const cv::Mat& inside, const cv::Mat& firm);

}  // namespace rotunda::capture
