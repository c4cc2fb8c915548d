#pragma once
// Pictures from what video cameras send: Y'CbCr with fewer colours than brightness samples, and Motion JPEG, as 8-bit
// RGB. Conversion by Rec. ITU-R BT.601 or BT.709, limited or full range (YcbcrCoding); colours are interpolated
// linearly. Within two of 255 of the exact equations; libswscale and libavcodec do the work.
#include <opencv2/core.hpp>

#include "capture/frame.h"

namespace rotunda::capture {

// Formats yuyv, uyvy and nv12, whole groups of pixels.
cv::Mat ycbcr_to_rgb(const Image& image);

// Format mjpeg; Huffman tables may be missing, as in AVI files (they are then those of ITU-T T.81, K.3). Throws
// CorruptData when the file is damaged, cut short or of another size than the image says: never half a picture.
cv::Mat jpeg_to_rgb(const Image& image);

// What can be told of a JPEG without decoding it: it begins and ends as it must and says this size. Empty if so, else
// what is wrong: "damaged JPEG: cut short". Zeros after the end are allowed, many cameras pad.
std::string jpeg_flaw(std::span<const std::uint8_t> bytes, int width, int height);

}  // namespace rotunda::capture
