#include "capture/matte/live_key.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/matte/chroma_key.h"
#include "capture/matte/half_picture.h"
#include "capture/picture.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

const cv::Size kSize(320, 240);
const cv::Point2d kCentre(161.3, 118.6);
constexpr double kRadius = 50.4;

// A disc of cloth before unevenly lit paint, softened by a pixel as by a lens; shadow on the floor below.
cv::Mat picture_of(const cv::Vec3b& paint, const cv::Vec3b& cloth, bool with_disc, double shadow = 1.0) {
  cv::Mat rgb(kSize, CV_8UC3);
  cv::RNG random(7);
  for (int y = 0; y < kSize.height; ++y)
    for (int x = 0; x < kSize.width; ++x) {
      const double light = (1.0 - 0.4 * x / kSize.width) * (y > 180 ? shadow : 1.0);
      const double a = with_disc ? std::clamp(0.5 + kRadius - std::hypot(x - kCentre.x, y - kCentre.y), 0.0, 1.0) : 0.0;
      for (int c = 0; c < 3; ++c)
        rgb.at<cv::Vec3b>(y, x)[c] =
            cv::saturate_cast<std::uint8_t>(a * cloth[c] + (1.0 - a) * light * paint[c] + random.gaussian(1.5));
    }
  return rgb;
}

std::vector<std::uint8_t> mosaic_of(const cv::Mat& rgb, PixelFormat format) {
  // Red stands at (0, 0) in RG, (1, 0) in GR, (0, 1) in GB, (1, 1) in BG.
  const int right = format == PixelFormat::bayer_gr8 || format == PixelFormat::bayer_bg8;
  const int down = format == PixelFormat::bayer_gb8 || format == PixelFormat::bayer_bg8;
  std::vector<std::uint8_t> samples;
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const bool red_row = (y & 1) == down, red_column = (x & 1) == right;
      samples.push_back(rgb.at<cv::Vec3b>(y, x)[red_row && red_column ? 0 : (red_row || red_column) ? 1 : 2]);
    }
  return samples;
}

Image sent(const cv::Mat& rgb, PixelFormat format) {
  if (format == PixelFormat::rgb8) return make_image(rgb.cols, rgb.rows, format, {rgb.datastart, rgb.dataend});
  return make_image(rgb.cols, rgb.rows, format, mosaic_of(rgb, format));
}

const cv::Vec3b kBlue(40, 80, 180), kGreen(50, 170, 70), kSkin(200, 150, 120);

double radius_of(const Matte& matte) {
  return std::sqrt(cv::sum(matte.alpha)[0] / 255.0 / CV_PI);
}

void expect_the_disc(const Matte& matte) {
  EXPECT_NEAR(radius_of(matte), kRadius, 0.35);  // half the size: twice the bias of the full key is allowed
  const auto moments = cv::moments(matte.alpha);
  EXPECT_NEAR(moments.m10 / moments.m00, kCentre.x, 0.15);
  EXPECT_NEAR(moments.m01 / moments.m00, kCentre.y, 0.15);
}

}  // namespace

TEST(LiveKey, FindsADiscInEveryMosaicWithoutShift) {
  for (const auto format : {PixelFormat::bayer_rg8, PixelFormat::bayer_gr8, PixelFormat::bayer_gb8,
                            PixelFormat::bayer_bg8, PixelFormat::rgb8}) {
    SCOPED_TRACE(to_string(format));
    const LiveKey key(picture_of(kBlue, {}, false), format);
    expect_the_disc(key(sent(picture_of(kBlue, kSkin, true), format)));
  }
}

TEST(LiveKey, TakesTheScreensColourFromThePlate) {
  const LiveKey key(picture_of(kGreen, {}, false), PixelFormat::bayer_rg8);
  expect_the_disc(key(sent(picture_of(kGreen, {120, 60, 150}, true), PixelFormat::bayer_rg8)));
}

TEST(LiveKey, LeavesShadowToTheBackdropAndDarkClothToThePerformer) {
  const LiveKey key(picture_of(kBlue, {}, false), PixelFormat::bayer_rg8);
  // Shadow on paint gets bluer: it is filled with light off the paint.
  cv::Mat shaded = picture_of(kBlue, {28, 28, 30}, true, 0.65);
  cv::Mat channels[3];
  cv::split(shaded, channels);
  channels[0].rowRange(181, kSize.height) *= 0.85;
  cv::merge(channels, 3, shaded);
  const auto matte = key(sent(shaded, PixelFormat::bayer_rg8));
  expect_the_disc(matte);
}

TEST(LiveKey, AgreesWithTheFullKeyOnWhoIsWhere) {
  const cv::Mat plate = picture_of(kBlue, {}, false);
  const LiveKey key(plate, PixelFormat::bayer_rg8);
  const auto image = sent(picture_of(kBlue, {90, 96, 110}, true), PixelFormat::bayer_rg8);
  const cv::Mat live = key(image).alpha > 127, full = chroma_key(to_rgb(image), {}, plate).alpha > 127;
  EXPECT_GT(cv::countNonZero(live & full), 0.97 * cv::countNonZero(live | full));
}

TEST(LiveKey, FillsAFoldTooDarkToTellInTheMiddleOfThePerformer) {
  cv::Mat rgb = picture_of(kBlue, kSkin, true);
  cv::circle(rgb, {155, 120}, 12, {3, 4, 22}, cv::FILLED);
  const LiveKey key(picture_of(kBlue, {}, false), PixelFormat::bayer_rg8);
  EXPECT_GT(cv::mean(key(sent(rgb, PixelFormat::bayer_rg8)).alpha(cv::Rect(143, 108, 25, 25)))[0], 250.0);
}

TEST(LiveKey, TakesALampThatThePlateDoesNotKnowForNobody) {
  const LiveKey key(picture_of(kBlue, {}, false), PixelFormat::bayer_rg8);
  cv::Mat picture = picture_of(kBlue, kSkin, true);
  cv::rectangle(picture, cv::Rect(200, 0, 70, 30), cv::Scalar::all(255), cv::FILLED);
  expect_the_disc(key(sent(picture, PixelFormat::bayer_rg8)));
}

TEST(LiveKey, KeepsToTheStage) {
  cv::Mat stage(kSize, CV_8UC1, cv::Scalar(255));
  stage.colRange(0, 60).setTo(0);
  cv::Mat rgb = picture_of(kBlue, kSkin, true);
  rgb.colRange(0, 50).setTo(cv::Scalar(20, 20, 20));  // past the screen's edge
  const LiveKey key(picture_of(kBlue, {}, false), PixelFormat::bayer_rg8, {.backdrop = {}, .stage = stage});
  expect_the_disc(key(sent(rgb, PixelFormat::bayer_rg8)));
}

TEST(LiveKey, IsTheSameOnOneThreadAndOnMany) {
  std::vector<LiveKey> keys;
  std::vector<Image> images;
  for (int i = 0; i < 6; ++i) {
    keys.emplace_back(picture_of(kBlue, {}, false), PixelFormat::bayer_rg8);
    images.push_back(
        sent(picture_of(kBlue, {static_cast<std::uint8_t>(60 + 25 * i), 90, 80}, true), PixelFormat::bayer_rg8));
  }
  const auto many = key_live(keys, images);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = key_live(keys, images);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_EQ(cv::countNonZero(many[i].alpha != single[i].alpha), 0);
}

TEST(LiveKey, FindsNobodyInAnEmptyStudioAndTakesOddSizes) {
  const cv::Mat empty = picture_of(kBlue, {}, false);
  const cv::Mat odd = empty(cv::Rect(0, 0, 41, 33)).clone();
  const auto matte = LiveKey(odd, PixelFormat::rgb8)(sent(odd, PixelFormat::rgb8));
  EXPECT_EQ(matte.alpha.size(), odd.size());
  EXPECT_EQ(cv::countNonZero(matte.alpha), 0);
}

TEST(LiveKey, RefusesWhatItCannotKey) {
  EXPECT_THROW(LiveKey(cv::Mat(kSize, CV_8UC3, cv::Scalar(90, 90, 90)), PixelFormat::bayer_rg8), InvalidInput);
  const cv::Mat plate = picture_of(kBlue, {}, false);
  const LiveKey key(plate, PixelFormat::bayer_rg8);
  EXPECT_THROW(key(sent(plate, PixelFormat::bayer_gb8)), InvalidInput);
  EXPECT_THROW(key_live(std::vector<LiveKey>{key}, {}), InvalidInput);
}

// A ramp of light in each colour: the half picture's values are the ramp's where it says its pixels stand.
TEST(HalfPicture, StandsWhereItsFourPixelsMeet) {
  cv::Mat rgb(20, 74, CV_8UC3);  // wide enough for vectors, and a rest
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x)
      rgb.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<std::uint8_t>(40 + 2 * x), static_cast<std::uint8_t>(20 + 4 * y),
                                          static_cast<std::uint8_t>(10 + 2 * x + 2 * y));
  for (const auto format : {PixelFormat::bayer_rg8, PixelFormat::bayer_gr8, PixelFormat::bayer_gb8,
                            PixelFormat::bayer_bg8, PixelFormat::rgb8}) {
    const auto half = half_picture(sent(rgb, format));
    for (int y = 1; y < 9; ++y)  // at the picture's ends the outermost photosites are repeated
      for (int x = 1; x < 36; ++x) {
        const double at_x = 2 * x + 0.5, at_y = 2 * y + 0.5;
        EXPECT_NEAR(half.planes[0].at<std::uint16_t>(y, x) / 16.0, 40 + 2 * at_x, 0.01) << to_string(format);
        EXPECT_NEAR(half.planes[1].at<std::uint16_t>(y, x) / 16.0, 20 + 4 * at_y, 0.01) << to_string(format);
        EXPECT_NEAR(half.planes[2].at<std::uint16_t>(y, x) / 16.0, 10 + 2 * at_x + 2 * at_y, 0.01) << to_string(format);
      }
  }
}

}  // namespace rotunda::capture
