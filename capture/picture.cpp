#include "capture/picture.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

// OpenCV names a mosaic by its second row and column, hence the *RGGB* aliases that name the first.
int demosaic_code(PixelFormat format) {
  switch (format) {
    case PixelFormat::bayer_rg8:
      return cv::COLOR_BayerRGGB2RGB;
    case PixelFormat::bayer_gr8:
      return cv::COLOR_BayerGRBG2RGB;
    case PixelFormat::bayer_gb8:
      return cv::COLOR_BayerGBRG2RGB;
    case PixelFormat::bayer_bg8:
      return cv::COLOR_BayerBGGR2RGB;
    default:
      return cv::COLOR_GRAY2RGB;
  }
}

// PFNC 12p: the first pixel's low byte, its high and the second's low nibble, the second's high byte.
cv::Mat unpack_12p(const Image& image) {
  cv::Mat samples(image.height, image.width, CV_16UC1);
  auto* out = samples.ptr<std::uint16_t>();
  const auto bytes = image.bytes();
  for (std::size_t i = 0, at = 0; i < samples.total(); ++i) {
    const bool second = (i & 1) != 0;
    const unsigned low = second ? bytes[at] >> 4U : bytes[at], high = second ? bytes[at + 1] : bytes[at + 1] & 0xFU;
    out[i] = static_cast<std::uint16_t>(second ? low | high << 4U : low | high << 8U);
    at += second ? 2 : 1;
  }
  return samples;
}

cv::Mat demosaic_12p(const Image& image) {
  cv::Mat deep, rgb;
  cv::cvtColor(unpack_12p(image), deep, cv::COLOR_BayerRGGB2RGB);
  deep.convertTo(rgb, CV_8U, 255.0 / 4095.0);
  return rgb;
}

cv::Mat read(const std::filesystem::path& file, int flags) {
  cv::Mat picture;
  try {
    picture = cv::imread(file.string(), flags);
  } catch (const cv::Exception& error) {
    throw CorruptData(file.string() + ": cannot be read as a picture: " + error.err);
  }
  if (picture.empty()) throw CorruptData(file.string() + ": is missing or not a picture (PNG or JPEG wanted)");
  return picture;
}

}  // namespace

cv::Mat to_rgb(const Image& image) {
  // const_cast: cv::Mat has no read-only view; nothing below writes through it.
  auto* data = const_cast<std::uint8_t*>(image.pixels.get());
  if (image.format == PixelFormat::bayer_rg12p) return demosaic_12p(image);
  if (image.format == PixelFormat::rgb8) return cv::Mat(image.height, image.width, CV_8UC3, data).clone();
  cv::Mat rgb;
  cv::cvtColor(cv::Mat(image.height, image.width, CV_8UC1, data), rgb, demosaic_code(image.format));
  return rgb;
}

cv::Mat read_rgb(const std::filesystem::path& file) {
  cv::Mat rgb;
  cv::cvtColor(read(file, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION), rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

cv::Mat read_grey(const std::filesystem::path& file) {
  return read(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
}

void write_png(const std::filesystem::path& file, const cv::Mat& picture) {
  cv::Mat out;  // not a share of the caller's pixels: converting in place would swap their red and blue
  if (picture.channels() == 1) out = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, out, cv::COLOR_RGB2BGR);
  if (picture.channels() == 4) cv::cvtColor(picture, out, cv::COLOR_RGBA2BGRA);
  bool written = false;
  try {
    written = cv::imwrite(file.string(), out, {cv::IMWRITE_PNG_COMPRESSION, 3});
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write " + file.string());
}

}  // namespace rotunda::capture
