#pragma once
// Pictures to work on: 8-bit sRGB in the order red, green, blue (CV_8UC3), never OpenCV's BGR; rows top to bottom.
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "capture/frame.h"

namespace rotunda::capture {

// Any Image as RGB; a mosaic is demosaiced bilinearly, mono is repeated in the three channels, Y'CbCr and JPEG are
// converted by ycbcr_picture.h. Throws CorruptData for a JPEG that came damaged.
cv::Mat to_rgb(const Image& image);

// The photosites of a mosaic as they are, CV_16UC1, 65535 the most that its bits can say; and such photosites
// as CV_8UC3, demosaiced as to_rgb() does. mosaic_of() throws InvalidInput for a format that is no mosaic.
bool is_mosaic(PixelFormat format);
cv::Mat mosaic_of(const Image& image);
cv::Mat demosaiced(const cv::Mat& mosaic, BayerOrder order);

// What a slot of a frame set shows: a picture, or why there is none, also where a camera sent a damaged JPEG.
struct SlotPicture {
  cv::Mat rgb;  // empty: none
  std::string missing_because;
};
SlotPicture picture_of(const FrameSlot& slot);

// PNG or JPEG from disk as RGB (grey is repeated, alpha dropped). Throws CorruptData with the file's name.
cv::Mat read_rgb(const std::filesystem::path& file);
cv::Mat read_grey(const std::filesystem::path& file);  // CV_8UC1
// Somebody's matte or silhouette as CV_8UC1, 255 performer: the alpha of a picture that has one, else its grey; 8 or 16
// bits. Masks of 0 and 1, and 8-bit values in a 16-bit file, are stretched to 255. Throws CorruptData, also for a
// picture in colour, which is no matte.
cv::Mat read_matte(const std::filesystem::path& file);

// CV_8UC1, CV_8UC3 (RGB), CV_8UC4 (RGBA, straight alpha) or CV_16UC1/3 as PNG. Throws std::system_error.
void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace rotunda::capture
