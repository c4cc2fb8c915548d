#pragma once
// A picture as the bytes a camera of a given format sends.
#include <opencv2/core.hpp>
#include <vector>

#include "capture/frame.h"

namespace rotunda::simulator {

// CV_8UC3, or CV_16UC3 with values of 12 bits (Sensor::expose), to rows top to bottom without padding. A mosaic keeps
// one of the three channels a pixel; BayerRG8 has red at (0, 0), green beside and below, blue at (1, 1). BayerRG12p is
// PFNC's packing: two pixels in three bytes, the lower bits first, rows following each other without a gap.
std::vector<std::uint8_t> encode_pixels(const cv::Mat& picture, capture::PixelFormat format);

}  // namespace rotunda::simulator
