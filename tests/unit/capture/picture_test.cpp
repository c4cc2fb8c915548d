#include "capture/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/ycbcr_picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

TEST(Picture, ComesBackFromItsFileAndIsLeftAsItWas) {
  const auto file = fs::temp_directory_path() / "rotunda-picture-test.png";
  cv::Mat rgb(3, 4, CV_8UC3, cv::Scalar(200, 100, 10));
  rgb.at<cv::Vec3b>(1, 2) = {1, 2, 3};
  const cv::Mat before = rgb.clone();
  for (int round = 0; round < 2; ++round) {
    write_png(file, rgb);
    EXPECT_TRUE(equal(rgb, before)) << "round " << round;
    EXPECT_TRUE(equal(read_rgb(file), before)) << "round " << round;
  }
  const cv::Mat grey(3, 4, CV_8UC1, cv::Scalar(77));
  write_png(file, grey);
  EXPECT_TRUE(equal(read_grey(file), grey));
  fs::remove(file);
}

using Bytes = std::vector<std::uint8_t>;

// What a sensor with this layout sends for a picture of one colour, given in its own units (0 to 2^bits - 1).
Bytes mosaic_of_one_colour(int width, int height, PixelFormat format, const cv::Vec3i& rgb) {
  const auto layout = layout_of(format);
  const int red_right = layout.order == BayerOrder::gr || layout.order == BayerOrder::bg;
  const int red_down = layout.order == BayerOrder::gb || layout.order == BayerOrder::bg;
  std::vector<unsigned> samples;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool red_row = y % 2 == red_down, red_column = x % 2 == red_right;
      samples.push_back(static_cast<unsigned>(red_row == red_column ? rgb[red_row ? 0 : 2] : rgb[1]));
    }
  Bytes bytes;
  const auto put = [&](unsigned value) { bytes.push_back(static_cast<std::uint8_t>(value & 0xFFU)); };
  if (layout.packing == PixelPacking::bytes)
    for (const unsigned s : samples) put(s);
  if (layout.packing == PixelPacking::words)
    for (const unsigned s : samples) put(s), put(s >> 8U);
  if (layout.packing == PixelPacking::pfnc_12p)
    for (std::size_t i = 0; i < samples.size(); i += 2)
      put(samples[i]), put(samples[i] >> 8U | samples[i + 1] << 4U), put(samples[i + 1] >> 4U);
  if (layout.packing == PixelPacking::csi2_12p)
    for (std::size_t i = 0; i < samples.size(); i += 2)
      put(samples[i] >> 4U), put(samples[i + 1] >> 4U), put((samples[i] & 15U) | (samples[i + 1] & 15U) << 4U);
  if (layout.packing == PixelPacking::csi2_10p)
    for (std::size_t i = 0; i < samples.size(); i += 4) {
      for (std::size_t k = 0; k < 4; ++k) put(samples[i + k] >> 2U);
      put((samples[i] & 3U) | (samples[i + 1] & 3U) << 2U | (samples[i + 2] & 3U) << 4U | (samples[i + 3] & 3U) << 6U);
    }
  return bytes;
}

TEST(ToRgb, GivesTheColourThatEveryBayerFormatCarries) {
  const cv::Vec3b rgb(200, 90, 33);
  int tried = 0;
  for (const auto format : pixel_formats()) {
    const auto layout = layout_of(format);
    if (layout.order == BayerOrder::none) continue;
    const double scale = ((1 << layout.bits) - 1) / 255.0;
    const cv::Vec3i sent(static_cast<int>(std::lround(200 * scale)), static_cast<int>(std::lround(90 * scale)),
                         static_cast<int>(std::lround(33 * scale)));
    const auto picture = to_rgb(make_image(16, 8, format, mosaic_of_one_colour(16, 8, format, sent)));
    ASSERT_EQ(picture.size(), cv::Size(16, 8));
    EXPECT_EQ(cv::norm(picture(cv::Rect(1, 1, 14, 6)), cv::Mat(6, 14, CV_8UC3, cv::Scalar(rgb)), cv::NORM_INF), 0.0)
        << to_string(format);
    ++tried;
  }
  EXPECT_EQ(tried, 21);
}

// Rec. ITU-R BT.601 and BT.709, quantised as they say for limited range, as JFIF says for full.
cv::Vec3d ycbcr_of(const cv::Vec3d& rgb, YcbcrCoding coding) {
  const bool bt709 = coding == YcbcrCoding::bt709_limited || coding == YcbcrCoding::bt709_full;
  const bool full = coding == YcbcrCoding::bt601_full || coding == YcbcrCoding::bt709_full;
  const double kr = bt709 ? 0.2126 : 0.299, kb = bt709 ? 0.0722 : 0.114;
  const double y = kr * rgb[0] + (1 - kr - kb) * rgb[1] + kb * rgb[2];
  const double cb = (rgb[2] - y) / (2 * (1 - kb)), cr = (rgb[0] - y) / (2 * (1 - kr));
  return full ? cv::Vec3d(y, 128 + cb, 128 + cr)
              : cv::Vec3d(16 + y * 219 / 255, 128 + cb * 224 / 255, 128 + cr * 224 / 255);
}

Bytes video_of_one_colour(int width, int height, PixelFormat format, const cv::Vec3d& ycbcr) {
  const auto y = cv::saturate_cast<std::uint8_t>(ycbcr[0]), cb = cv::saturate_cast<std::uint8_t>(ycbcr[1]),
             cr = cv::saturate_cast<std::uint8_t>(ycbcr[2]);
  Bytes bytes;
  if (format == PixelFormat::nv12) bytes.assign(static_cast<std::size_t>(width * height), y);
  while (bytes.size() < image_bytes(width, height, format)) {
    if (format == PixelFormat::nv12) bytes.insert(bytes.end(), {cb, cr});
    if (format == PixelFormat::yuyv) bytes.insert(bytes.end(), {y, cb, y, cr});
    if (format == PixelFormat::uyvy) bytes.insert(bytes.end(), {cb, y, cr, y});
  }
  return bytes;
}

// One unit of rounding in Y', Cb or Cr is up to two in blue.
TEST(ToRgb, FollowsTheEquationsOfEveryYcbcrCoding) {
  const cv::Vec3d colours[] = {{0, 0, 0},     {255, 255, 255}, {20, 60, 220},
                               {200, 90, 33}, {30, 180, 60},   {128, 128, 128}};
  for (const auto format : {PixelFormat::yuyv, PixelFormat::uyvy, PixelFormat::nv12})
    for (const auto coding :
         {YcbcrCoding::bt601_limited, YcbcrCoding::bt601_full, YcbcrCoding::bt709_limited, YcbcrCoding::bt709_full})
      for (const auto& rgb : colours) {
        const auto bytes = video_of_one_colour(36, 10, format, ycbcr_of(rgb, coding));
        const auto picture = to_rgb(make_image(36, 10, format, bytes, coding));
        const cv::Mat expected(10, 36, CV_8UC3, cv::Scalar(rgb));
        EXPECT_LE(cv::norm(picture, expected, cv::NORM_INF), 2.0)
            << to_string(format) << " " << to_string(coding) << " " << rgb;
      }
}

TEST(ToRgb, RefusesAnImageWhosePixelsDoNotFillTheirGroups) {
  EXPECT_THROW(to_rgb(make_image(5, 4, PixelFormat::yuyv, Bytes(40))), CorruptData);
  EXPECT_THROW(to_rgb(make_image(4, 3, PixelFormat::nv12, Bytes(18))), CorruptData);
  EXPECT_THROW(to_rgb(make_image(6, 2, PixelFormat::bayer_rg10_csi2p, Bytes(15))), CorruptData);
}

cv::Mat soft_colours() {
  cv::Mat rgb(48, 64, CV_8UC3);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x)
      rgb.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<std::uint8_t>(3 * x + 20), static_cast<std::uint8_t>(4 * y + 30),
                                          static_cast<std::uint8_t>(200 - 2 * x));
  return rgb;
}

Bytes jpeg_of(const cv::Mat& rgb) {
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  Bytes bytes;
  cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
  return bytes;
}

Image jpeg_image(Bytes bytes) {
  return make_image(64, 48, PixelFormat::mjpeg, std::move(bytes));
}

TEST(JpegToRgb, ReadsWhatAnotherEncoderWrote) {
  const cv::Mat rgb = soft_colours();
  Bytes bytes = jpeg_of(rgb);
  bytes.resize(bytes.size() + 40);  // cameras pad with zeros
  const auto picture = to_rgb(jpeg_image(std::move(bytes)));
  ASSERT_EQ(picture.size(), rgb.size());
  EXPECT_LE(cv::norm(picture, rgb, cv::NORM_L1) / static_cast<double>(rgb.total() * 3), 2.0);  // mean of quality 95
}

TEST(JpegToRgb, RefusesEveryTruncationAlsoOneThatEndsAsItMust) {
  const Bytes whole = jpeg_of(soft_colours());
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    if (cut.empty()) cut.push_back(0);
    EXPECT_THROW(to_rgb(jpeg_image(cut)), CorruptData) << size;
  }
  Bytes patched(whole.begin(), whole.end() - static_cast<std::ptrdiff_t>(whole.size() / 4));
  patched.insert(patched.end(), {0xFF, 0xD9});
  EXPECT_THROW(to_rgb(jpeg_image(patched)), CorruptData);
}

TEST(JpegToRgb, AFlippedByteGivesAPictureOfTheSameSizeOrIsRefused) {
  const Bytes whole = jpeg_of(soft_colours());
  for (std::size_t at = 0; at < whole.size(); ++at) {
    Bytes flipped = whole;
    flipped[at] ^= 0xFFU;
    try {
      EXPECT_EQ(to_rgb(jpeg_image(std::move(flipped))).size(), cv::Size(64, 48)) << at;
    } catch (const CorruptData&) {
    }
  }
}

TEST(PictureOf, SaysWhyASlotHasNoPicture) {
  FrameSlot slot;
  slot.missing_because = HoleReason::late;
  EXPECT_EQ(picture_of(slot).missing_because, "late");
  Bytes cut = jpeg_of(soft_colours());
  cut.resize(cut.size() / 2);
  slot.frame = Frame{};
  slot.frame->image = jpeg_image(std::move(cut));
  EXPECT_TRUE(picture_of(slot).rgb.empty());
  EXPECT_THAT(picture_of(slot).missing_because, testing::HasSubstr("damaged JPEG: cut short"));
}

}  // namespace
}  // namespace rotunda::capture
