#pragma once
// A picture at half its size, for the live key: one value of red, green and blue for every 2 x 2 pixels, all three
// where the four meet. Of a mosaic the photosites themselves are taken, bilinearly, so no demosaicing is needed first.
#include <array>
#include <opencv2/core.hpp>

#include "capture/frame.h"

namespace rotunda::capture {

// Pixel (x, y) stands at (2 x + 0.5, 2 y + 0.5) of the whole picture. Odd last rows and columns are left out.
struct HalfPicture {
  std::array<cv::Mat, 3> planes;  // red, green, blue; CV_16UC1, 1/16 of a grey level
};
inline constexpr int kHalfScale = 16;

// Any Image; all but 8-bit mosaics go through to_rgb. Throws CorruptData as that does.
HalfPicture half_picture(const Image& image);
// Of a picture (CV_8UC3, RGB): the photosites that a camera of this format would have had.
HalfPicture half_picture(const cv::Mat& rgb, PixelFormat format);

}  // namespace rotunda::capture
