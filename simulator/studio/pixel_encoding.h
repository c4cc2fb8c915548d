#pragma once
// An RGB picture as the bytes a camera of a given format sends.
#include <opencv2/core.hpp>
#include <vector>

#include "capture/frame.h"

namespace rotunda::simulator {

// CV_8UC3 to rows top to bottom without padding. A mosaic keeps one of the three channels a pixel; BayerRG8 has red at
// (0, 0), green beside and below, blue at (1, 1).
std::vector<std::uint8_t> encode_pixels(const cv::Mat& rgb, capture::PixelFormat format);

}  // namespace rotunda::simulator
