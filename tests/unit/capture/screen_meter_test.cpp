#include "capture/matte/screen_meter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/matte/screen_overlay.h"
#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const cv::Scalar kPaint(0.05, 0.10, 0.40);  // linear; saturation 0.75

// Blue paint under light that rises from 1 at the left to `ratio` at the right, with white light added, noise in codes.
cv::Mat screen(double ratio, double white, double noise, int seed) {
  cv::Mat picture(120, 160, CV_8UC3);
  cv::RNG random(static_cast<std::uint64_t>(seed));
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        const double light = 1.0 + (ratio - 1.0) * x / (picture.cols - 1);
        const double code = 255.0 * srgb_of_linear(std::min(1.0, (kPaint[c] + white) * light / ratio));
        picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(code + random.gaussian(noise));
      }
  return picture;
}

std::vector<cv::Mat> twice(double ratio, double white, double noise) {
  return {screen(ratio, white, noise, 1), screen(ratio, white, noise, 2)};
}

TEST(ScreenMeter, OfAGoodScreenHasNothingToSay) {
  const auto reading = measure_screen(twice(1.2, 0.0, 1.0), Backdrop::blue);
  EXPECT_THAT(reading.advice, IsEmpty());
  EXPECT_NEAR(reading.share, 1.0, 1e-9);
  EXPECT_NEAR(reading.saturation, 0.75, 0.02);
  EXPECT_NEAR(reading.unevenness, 1.18, 0.03);  // 90 % of the way from 1 to 1.2
  EXPECT_NEAR(reading.noise, 1.0, 0.2);         // of two pictures rounded to levels
  EXPECT_FALSE(reading.spill);
}

TEST(ScreenMeter, NoiseOfOnePictureIsItsFinestDetail) {
  const auto one = screen(1.5, 0.0, 4.0, 1);
  EXPECT_NEAR(measure_screen(std::span(&one, 1), Backdrop::blue).noise, 4.0, 0.3);
  EXPECT_NEAR(measure_screen(twice(1.5, 0.0, 4.0), Backdrop::blue).noise, 4.0, 0.3);
}

TEST(ScreenMeter, NamesWhatIsWrongAndWhere) {
  const auto uneven = measure_screen(twice(3.0, 0.0, 1.0), Backdrop::blue);
  EXPECT_EQ(uneven.brightest.substr(uneven.brightest.size() - 5), "right");
  EXPECT_EQ(uneven.darkest.substr(uneven.darkest.size() - 4), "left");
  EXPECT_THAT(uneven.advice, ElementsAre(HasSubstr("uneven")));
  EXPECT_THAT(measure_screen(twice(1.1, 0.5, 1.0), Backdrop::blue).advice, ElementsAre(HasSubstr("weak")));
  EXPECT_THAT(measure_screen(twice(1.0, 0.0, 14.0), Backdrop::blue).advice, ::testing::Contains(HasSubstr("noisy")));
  EXPECT_THAT(measure_screen(twice(1.0, 0.0, 1.0), Backdrop::green).advice, ElementsAre(HasSubstr("no green screen")));
  auto bright = screen(1.0, 0.0, 0.0, 1);
  bright(cv::Rect(0, 0, 80, 60)).setTo(cv::Scalar(60, 80, 255));
  const auto clipped = measure_screen(std::span(&bright, 1), Backdrop::blue);
  EXPECT_NEAR(clipped.clipped, 0.25, 0.01);
  EXPECT_THAT(clipped.advice, ::testing::Contains(HasSubstr("over-exposed")));
}

// A grey disc with a blue rim of 20 levels, five pixels wide.
TEST(ScreenMeter, SpillIsWhatTheRimHasBeyondTheCloth) {
  cv::Mat picture = screen(1.0, 0.0, 0.0, 1), alpha(picture.size(), CV_8UC1, cv::Scalar(0));
  cv::circle(picture, {80, 60}, 40, {100, 100, 120}, cv::FILLED);
  cv::circle(picture, {80, 60}, 33, {100, 100, 100}, cv::FILLED);
  cv::circle(alpha, {80, 60}, 40, {255}, cv::FILLED);
  const auto reading = measure_screen(std::span(&picture, 1), Backdrop::blue, alpha);
  ASSERT_TRUE(reading.spill);
  EXPECT_NEAR(*reading.spill, 20.0, 1.0);
  EXPECT_THAT(reading.advice, ElementsAre(HasSubstr("spill")));
}

TEST(ScreenMeter, TheOverlayIsLoudWhereTheScreenIsDarkOrBrightAndQuietBetween) {
  const auto picture = screen(3.0, 0.0, 0.0, 1);
  const auto reading = measure_screen(std::span(&picture, 1), Backdrop::blue);
  const auto overlay = screen_overlay({picture, {}, "cam00"}, Backdrop::blue, reading);
  ASSERT_EQ(overlay.cols, picture.cols);
  EXPECT_GT(overlay.rows, picture.rows);
  const auto left = overlay.at<cv::Vec3b>(60, 2), right = overlay.at<cv::Vec3b>(60, 157);
  EXPECT_EQ(left, cv::Vec3b(45, 85, 235));
  EXPECT_GT(right[0], right[2]);
  EXPECT_LT(overlay.at<cv::Vec3b>(60, 80)[2], picture.at<cv::Vec3b>(60, 80)[2]);  // its own colour, dimmed
  cv::Mat performer = cv::Mat::zeros(picture.size(), CV_8UC1);
  performer(cv::Rect(0, 40, 20, 40)).setTo(255);
  const auto with_performer = screen_overlay({picture, performer, "cam00"}, Backdrop::blue, reading);
  const auto grey = with_performer.at<cv::Vec3b>(60, 2);
  EXPECT_EQ(grey[0], grey[2]);
}

TEST(ScreenMeter, PicturesThatDoNotFitAreRefused) {
  EXPECT_THROW(measure_screen({}, Backdrop::blue), InvalidInput);
  const std::vector<cv::Mat> unlike = {screen(1, 0, 0, 1), cv::Mat(10, 10, CV_8UC3)};
  EXPECT_THROW(measure_screen(unlike, Backdrop::blue), InvalidInput);
  EXPECT_THROW(screen_overlay({unlike[0], cv::Mat::zeros(5, 5, CV_8UC1), ""}, Backdrop::blue, {}), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
