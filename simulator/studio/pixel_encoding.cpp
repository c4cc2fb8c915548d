#include "simulator/studio/pixel_encoding.h"

#include <opencv2/imgproc.hpp>

namespace rotunda::simulator {
namespace {

using capture::PixelFormat;

std::vector<std::uint8_t> bytes_of(const cv::Mat& picture) {
  const cv::Mat packed = picture.isContinuous() ? picture : picture.clone();
  return {packed.datastart, packed.dataend};
}

// `right`, `down`: how far the red pixel stands from (0, 0).
std::vector<std::uint8_t> mosaic(const cv::Mat& rgb, int right, int down) {
  std::vector<std::uint8_t> bytes(rgb.total());
  auto out = bytes.begin();
  for (int y = 0; y < rgb.rows; ++y) {
    const auto* row = rgb.ptr<cv::Vec3b>(y);
    const int row_is_blue = (y + down) & 1;
    for (int x = 0; x < rgb.cols; ++x) *out++ = row[x][row_is_blue + ((x + right) & 1)];
  }
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> encode_pixels(const cv::Mat& rgb, PixelFormat format) {
  switch (format) {
    case PixelFormat::bayer_rg8:
      return mosaic(rgb, 0, 0);
    case PixelFormat::bayer_gr8:
      return mosaic(rgb, 1, 0);
    case PixelFormat::bayer_gb8:
      return mosaic(rgb, 0, 1);
    case PixelFormat::bayer_bg8:
      return mosaic(rgb, 1, 1);
    case PixelFormat::rgb8:
      return bytes_of(rgb);
    case PixelFormat::mono8:
      break;
  }
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  return bytes_of(grey);
}

}  // namespace rotunda::simulator
