#include "simulator/studio/pixel_encoding.h"

#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "simulator/studio/sensor.h"

namespace rotunda::simulator {
namespace {

using capture::PixelFormat;

std::vector<std::uint8_t> bytes_of(const cv::Mat& picture) {
  const cv::Mat packed = picture.isContinuous() ? picture : picture.clone();
  return {packed.datastart, packed.dataend};
}

// `right`, `down`: how far the red pixel stands from (0, 0).
template <class Sample>
std::vector<Sample> mosaic(const cv::Mat& rgb, int right, int down) {
  std::vector<Sample> samples(rgb.total());
  auto out = samples.begin();
  for (int y = 0; y < rgb.rows; ++y) {
    const auto* row = rgb.ptr<cv::Vec<Sample, 3>>(y);
    const int row_is_blue = (y + down) & 1;
    for (int x = 0; x < rgb.cols; ++x) *out++ = row[x][row_is_blue + ((x + right) & 1)];
  }
  return samples;
}

std::vector<std::uint8_t> mosaic8(const cv::Mat& picture, int right, int down) {
  if (picture.depth() == CV_8U) return mosaic<std::uint8_t>(picture, right, down);
  const auto deep = mosaic<std::uint16_t>(picture, right, down);
  std::vector<std::uint8_t> bytes(deep.size());
  cv::Mat out(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data());
  to_8bit(cv::Mat(1, static_cast<int>(deep.size()), CV_16UC1, const_cast<std::uint16_t*>(deep.data()))).copyTo(out);
  return bytes;
}

std::vector<std::uint8_t> pack_12p(const std::vector<std::uint16_t>& samples) {
  std::vector<std::uint8_t> bytes((samples.size() * 12 + 7) / 8, 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t at = i / 2 * 3;
    const unsigned value = samples[i];
    if (i % 2 == 0) {
      bytes[at] = static_cast<std::uint8_t>(value & 0xFFU);
      bytes[at + 1] = static_cast<std::uint8_t>(value >> 8U);
    } else {
      bytes[at + 1] = static_cast<std::uint8_t>(bytes[at + 1] | (value & 0xFU) << 4U);
      bytes[at + 2] = static_cast<std::uint8_t>(value >> 4U);
    }
  }
  return bytes;
}

std::vector<std::uint8_t> mosaic_12p(const cv::Mat& picture) {
  cv::Mat deep = picture;
  if (picture.depth() == CV_8U) picture.convertTo(deep, CV_16U, 4095.0 / 255.0);
  return pack_12p(mosaic<std::uint16_t>(deep, 0, 0));
}

}  // namespace

std::vector<std::uint8_t> encode_pixels(const cv::Mat& picture, PixelFormat format) {
  switch (format) {
    case PixelFormat::bayer_rg8:
      return mosaic8(picture, 0, 0);
    case PixelFormat::bayer_gr8:
      return mosaic8(picture, 1, 0);
    case PixelFormat::bayer_gb8:
      return mosaic8(picture, 0, 1);
    case PixelFormat::bayer_bg8:
      return mosaic8(picture, 1, 1);
    case PixelFormat::bayer_rg12p:
      return mosaic_12p(picture);
    case PixelFormat::rgb8:
    case PixelFormat::mono8:
      break;
    default:
      throw InvalidInput("the simulator does not send " + std::string(capture::to_string(format)));
  }
  const cv::Mat rgb = picture.depth() == CV_8U ? picture : to_8bit(picture);
  if (format == PixelFormat::rgb8) return bytes_of(rgb);
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  return bytes_of(grey);
}

}  // namespace rotunda::simulator
