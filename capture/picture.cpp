#include "capture/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <vector>

#include "capture/packed_samples.h"
#include "capture/ycbcr_picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

// OpenCV names a mosaic by its second row and column, hence the *RGGB* aliases that name the first.
int demosaic_code(BayerOrder order) {
  switch (order) {
    case BayerOrder::rg:
      return cv::COLOR_BayerRGGB2RGB;
    case BayerOrder::gr:
      return cv::COLOR_BayerGRBG2RGB;
    case BayerOrder::gb:
      return cv::COLOR_BayerGBRG2RGB;
    case BayerOrder::bg:
      return cv::COLOR_BayerBGGR2RGB;
    case BayerOrder::none:
      break;
  }
  return cv::COLOR_GRAY2RGB;
}

// Samples above what the bits can say are a camera's mistake; they show as white.
cv::Mat unpack(const Image& image, const PixelLayout& layout) {
  cv::Mat samples(image.height, image.width, CV_16UC1);
  const auto unpacked = unpack_samples(image.bytes(), samples.total(), layout.packing);
  const auto white = static_cast<std::uint16_t>((1U << layout.bits) - 1);
  std::transform(unpacked.begin(), unpacked.end(), samples.ptr<std::uint16_t>(),
                 [&](std::uint16_t sample) { return std::min(sample, white); });
  return samples;
}

cv::Mat demosaic_deep(const Image& image, const PixelLayout& layout) {
  cv::Mat deep, rgb;
  cv::cvtColor(unpack(image, layout), deep, demosaic_code(layout.order));
  deep.convertTo(rgb, CV_8U, 255.0 / ((1 << layout.bits) - 1));
  return rgb;
}

void require_whole_groups(const Image& image) {
  const auto group = pixel_group(image.format);
  if (image.width <= 0 || image.height <= 0 || image.width % group.across != 0 || image.height % group.down != 0)
    throw CorruptData(
        fmt::format("an image of {} x {} pixels cannot be {}", image.width, image.height, to_string(image.format)));
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

// Alpha that is the same everywhere says nothing: the picture was merely saved with one.
bool says_something(const cv::Mat& alpha) {
  double least = 0, most = 0;
  cv::minMaxLoc(alpha, &least, &most);
  return least < most;
}

// One plane of whatever was in the file, in its own depth.
cv::Mat matte_plane(const std::filesystem::path& file, const cv::Mat& picture) {
  constexpr double kMostColour = 8.0;  // of 255, mean: what JPEG makes of grey stays below
  std::vector<cv::Mat> planes;
  cv::split(picture, planes);
  if (planes.size() == 1) return planes[0];
  if ((planes.size() == 4 || planes.size() == 2) && says_something(planes.back())) return planes.back();
  const double white = picture.depth() == CV_16U ? 65535.0 : 255.0;
  for (std::size_t i = 1; i < 3 && planes.size() >= 3; ++i)
    if (cv::norm(planes[0], planes[i], cv::NORM_L1) / static_cast<double>(picture.total()) >
        kMostColour * white / 255.0)
      throw CorruptData(file.string() + ": is a picture in colour; a matte is grey, or an alpha channel");
  return planes[planes.size() >= 3 ? 1 : 0];
}

}  // namespace

cv::Mat to_rgb(const Image& image) {
  require_whole_groups(image);
  const PixelLayout layout = layout_of(image.format);
  if (image.format == PixelFormat::mjpeg) return jpeg_to_rgb(image);
  if (is_ycbcr(image.format)) return ycbcr_to_rgb(image);
  if (layout.packing != PixelPacking::bytes) return demosaic_deep(image, layout);
  // const_cast: cv::Mat has no read-only view; nothing below writes through it.
  auto* data = const_cast<std::uint8_t*>(image.pixels.get());
  if (image.format == PixelFormat::rgb8) return cv::Mat(image.height, image.width, CV_8UC3, data).clone();
  cv::Mat rgb;
  cv::cvtColor(cv::Mat(image.height, image.width, CV_8UC1, data), rgb, demosaic_code(layout.order));
  return rgb;
}

bool is_mosaic(PixelFormat format) {
  return layout_of(format).order != BayerOrder::none;
}

cv::Mat mosaic_of(const Image& image) {
  if (!is_mosaic(image.format))
    throw InvalidInput(fmt::format("an image of {} has no photosites to speak of", to_string(image.format)));
  require_whole_groups(image);
  const PixelLayout layout = layout_of(image.format);
  cv::Mat sites;
  if (layout.packing == PixelPacking::bytes)  // const_cast: as in to_rgb()
    cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.get()))
        .convertTo(sites, CV_16U, 257.0);
  else
    unpack(image, layout).convertTo(sites, CV_16U, 65535.0 / ((1 << layout.bits) - 1));
  return sites;
}

cv::Mat demosaiced(const cv::Mat& mosaic, BayerOrder order) {
  cv::Mat deep, rgb;
  cv::cvtColor(mosaic, deep, demosaic_code(order));
  deep.convertTo(rgb, CV_8U, 255.0 / 65535.0);
  return rgb;
}

SlotPicture picture_of(const FrameSlot& slot) {
  if (!slot.frame) return {{}, std::string(to_string(slot.missing_because.value_or(HoleReason::not_recorded)))};
  try {
    return {to_rgb(slot.frame->image), ""};
  } catch (const CorruptData& error) {
    return {{}, error.what()};
  }
}

cv::Mat read_rgb(const std::filesystem::path& file) {
  cv::Mat rgb;
  cv::cvtColor(read(file, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION), rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

cv::Mat read_grey(const std::filesystem::path& file) {
  return read(file, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat read_matte(const std::filesystem::path& file) {
  const cv::Mat picture = read(file, cv::IMREAD_UNCHANGED);
  if (picture.depth() != CV_8U && picture.depth() != CV_16U)
    throw CorruptData(file.string() + ": a matte has 8 or 16 bits a pixel");
  const cv::Mat plane = matte_plane(file, picture);
  double least = 0, most = 0;
  cv::minMaxLoc(plane, &least, &most);
  const double white = most <= 1.0 ? 1.0 : plane.depth() == CV_16U && most > 255.0 ? 65535.0 : 255.0;
  cv::Mat alpha;
  plane.convertTo(alpha, CV_8U, 255.0 / white);
  return alpha;
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
