#include "simulator/studio/sensor.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "capture/picture.h"
#include "simulator/studio/pixel_encoding.h"

namespace rotunda::simulator {
namespace {

const cv::Size kSize(160, 120);

double srgb_decode(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

cv::Mat grey(double light) {
  return cv::Mat(kSize, CV_32FC3, cv::Scalar::all(light));
}

SensorOptions even_sensor() {
  SensorOptions options;
  options.gain_spread = options.balance_spread = options.vignetting = options.hot_pixels_per_mega = 0.0;
  return options;
}

struct Transfer {
  double mean = 0.0, variance = 0.0;  // of the green pixels, converter codes
};

// EMVA 1288's way: half the variance of the difference of two pictures holds no fixed pattern.
Transfer transfer_of(const Sensor& sensor, double light) {
  const auto a = sensor.expose(grey(light), 1), b = sensor.expose(grey(light), 2);
  Transfer transfer;
  double squares = 0.0;
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x) {
      const double p = 4095.0 * srgb_decode(a.at<cv::Vec3w>(y, x)[1] / 4095.0);
      const double q = 4095.0 * srgb_decode(b.at<cv::Vec3w>(y, x)[1] / 4095.0);
      transfer.mean += 0.5 * (p + q), squares += 0.5 * (p - q) * (p - q);
    }
  const auto count = static_cast<double>(a.total());
  transfer.mean /= count;
  transfer.variance = squares / count;
  return transfer;
}

// The slope of variance over signal is the system gain (photon transfer), whatever exposure and gain are set.
TEST(Sensor, NoiseFollowsThePhotonTransferCurve) {
  for (const double gain_db : {0.0, 6.0}) {
    auto options = even_sensor();
    options.cameras = {{.gain_db = gain_db}};
    const Sensor sensor(kSize, 0, options);
    const double amplification = std::pow(10.0, gain_db / 20.0);
    const double expected = 4095.0 / options.full_well * amplification;  // codes an electron
    double sxx = 0.0, sxy = 0.0, sx = 0.0, sy = 0.0, n = 0.0;
    for (const double light : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}) {
      const auto t = transfer_of(sensor, light / amplification);
      EXPECT_NEAR(t.mean, 4095.0 * light, 4095.0 * 0.01) << light;
      sx += t.mean, sy += t.variance, sxx += t.mean * t.mean, sxy += t.mean * t.variance, ++n;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    EXPECT_NEAR(slope, expected, 0.03 * expected) << gain_db << " dB";
    const double dark = (sy - slope * sx) / n;  // read noise and the steps of converter and curve
    EXPECT_NEAR(dark, std::pow(expected * options.read_noise, 2), 0.15 * expected * expected * 1000.0);
  }
}

TEST(Sensor, FollowsExposureGainAndWhiteBalance) {
  auto options = even_sensor();
  options.cameras = {{}, {.exposure_s = 0.0025}, {.gain_db = 6.0206}, {.red_balance = 1.5, .blue_balance = 0.5}};
  const auto mean = [&](std::size_t camera) {
    cv::Scalar sum;
    const auto picture = Sensor(kSize, camera, options).expose(grey(0.2), 3);
    for (int y = 0; y < picture.rows; ++y)
      for (int x = 0; x < picture.cols; ++x)
        for (int c = 0; c < 3; ++c) sum[c] += srgb_decode(picture.at<cv::Vec3w>(y, x)[c] / 4095.0);
    return sum / static_cast<double>(picture.total());
  };
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean(0)[c], 0.2, 0.003);
    EXPECT_NEAR(mean(1)[c], 0.1, 0.003);
    EXPECT_NEAR(mean(2)[c], 0.4, 0.005);
  }
  EXPECT_NEAR(mean(3)[0], 0.3, 0.004);
  EXPECT_NEAR(mean(3)[1], 0.2, 0.003);
  EXPECT_NEAR(mean(3)[2], 0.1, 0.003);
}

TEST(Sensor, CornersAreDarkerAsTheCosineSaysAndTheMiddleIsNot) {
  auto options = even_sensor();
  options.vignetting = 0.3;
  const auto picture = Sensor({161, 121}, 0, options).expose(cv::Mat(121, 161, CV_32FC3, cv::Scalar::all(0.5)), 1);
  const auto light = [&](cv::Rect at) { return srgb_decode(cv::mean(picture(at))[1] / 4095.0); };
  EXPECT_NEAR(light({76, 56, 9, 9}), 0.5, 0.01);
  const double corner = light({0, 0, 5, 5}) / 0.5;
  EXPECT_GT(corner, 1.0 - 0.3 * 4.0 / 3.0 - 0.02);
  EXPECT_LT(corner, 1.0 - 0.3 * 2.0 / 3.0 + 0.04);
}

TEST(Sensor, HotPixelsStayWhereTheyAreAndGrowWithTheExposure) {
  auto options = even_sensor();
  options.hot_pixels_per_mega = 1000.0;
  options.cameras = {{.exposure_s = 0.005}, {.exposure_s = 0.020}};
  const auto dark = [&](std::size_t camera, std::uint32_t seed, std::uint64_t frame) {
    auto seeded = options;
    seeded.seed = seed;
    return Sensor(kSize, camera, seeded).expose(grey(0.0), frame);
  };
  const auto bright = [](const cv::Mat& picture) {
    cv::Mat green;
    cv::extractChannel(picture, green, 1);
    return cv::Mat(green > 900);  // far above the noise: 4095 srgb(45 electrons) = 520
  };
  const cv::Mat first = bright(dark(0, 1, 1)), second = bright(dark(0, 1, 2)), other = bright(dark(0, 2, 1));
  EXPECT_GE(cv::countNonZero(first), 5);
  EXPECT_GE(cv::countNonZero(first & second), cv::countNonZero(first) * 8 / 10);
  EXPECT_LE(cv::countNonZero(first & other), 1);
  EXPECT_GT(cv::countNonZero(bright(dark(1, 1, 1))), cv::countNonZero(first));
}

TEST(Sensor, IsTheSameOnOneAndManyThreads) {
  const Sensor sensor(kSize, 3, {});
  const auto many = sensor.expose(grey(0.3), 5);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(cv::norm(sensor.expose(grey(0.3), 5), many, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(sensor.expose(grey(0.3), 6), many, cv::NORM_INF), 0.0);
}

TEST(PixelEncoding, BayerRG8HasRedFirst) {
  const cv::Mat rgb(4, 6, CV_8UC3, cv::Scalar(200, 100, 50));
  const auto bytes = encode_pixels(rgb, capture::PixelFormat::bayer_rg8);
  EXPECT_EQ(bytes[0], 200);
  EXPECT_EQ(bytes[1], 100);
  EXPECT_EQ(bytes[6], 100);
  EXPECT_EQ(bytes[7], 50);
}

TEST(PixelEncoding, EveryFormatComesBackAsTheColourItWas) {
  const cv::Mat rgb(8, 8, CV_8UC3, cv::Scalar(200, 100, 50));
  cv::Mat deep;
  rgb.convertTo(deep, CV_16U, 4095.0 / 255.0);
  using enum capture::PixelFormat;
  for (const auto format : {bayer_rg8, bayer_gr8, bayer_gb8, bayer_bg8, rgb8, bayer_rg12p})
    for (const auto& picture : {rgb, deep}) {
      const auto image = capture::make_image(8, 8, format, encode_pixels(picture, format));
      const auto middle = capture::to_rgb(image).at<cv::Vec3b>(4, 4);
      EXPECT_EQ(middle, cv::Vec3b(200, 100, 50)) << capture::to_string(format);
    }
}

TEST(PixelEncoding, TwelveBitsArePackedTwoInThreeBytesLowBitsFirst) {
  cv::Mat deep(2, 3, CV_16UC3, cv::Scalar::all(0));
  for (int i = 0; i < 6; ++i)
    deep.at<cv::Vec3w>(i / 3, i % 3) = cv::Vec3w::all(static_cast<std::uint16_t>(0x111 * i + 0x123));
  const std::vector<std::uint8_t> expected{0x23, 0x41, 0x23, 0x45, 0x63, 0x45, 0x67, 0x85, 0x67};
  EXPECT_EQ(encode_pixels(deep, capture::PixelFormat::bayer_rg12p), expected);  // the second row begins mid-byte
  EXPECT_EQ(expected.size(), capture::image_bytes(3, 2, capture::PixelFormat::bayer_rg12p));
}

}  // namespace
}  // namespace rotunda::simulator
