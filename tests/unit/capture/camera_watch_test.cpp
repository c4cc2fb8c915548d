#include "capture/calibration/camera_watch.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

// A wall with things on it, seen with noise after the camera was moved.
cv::Mat wall(double dx, double dy, double turn_deg, unsigned seed, bool somebody = false) {
  cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(80));
  cv::RNG things(7);
  for (int i = 0; i < 40; ++i)
    cv::rectangle(
        picture, cv::Rect(things.uniform(0, 300), things.uniform(0, 220), things.uniform(4, 30), things.uniform(4, 30)),
        cv::Scalar(things.uniform(30, 220)), cv::FILLED);
  cv::Mat turn = cv::getRotationMatrix2D({159.5F, 119.5F}, turn_deg, 1.0);
  turn.at<double>(0, 2) += dx;
  turn.at<double>(1, 2) += dy;
  cv::GaussianBlur(picture, picture, {}, 0.8);
  cv::warpAffine(picture, picture, turn, picture.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  if (somebody) cv::ellipse(picture, {150, 130}, {35, 90}, 0, 0, 360, cv::Scalar(190), cv::FILLED);
  cv::Mat noise(picture.size(), CV_16SC1), noisy;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 2.0);
  picture.convertTo(noisy, CV_16SC1);
  noisy += noise;
  noisy.convertTo(picture, CV_8UC1);
  return picture;
}

TEST(CameraWatch, SeesThatTheBackgroundMovedAndByHowMuch) {
  const auto before = wall(0, 0, 0, 1);
  const auto still = background_shift(before, wall(0, 0, 0, 2, true));
  ASSERT_TRUE(still);
  EXPECT_LT(still->shift_px, 0.15);
  EXPECT_FALSE(has_moved(*still));
  const auto knocked = background_shift(before, wall(3.3, -1.6, 0, 3, true));
  ASSERT_TRUE(knocked);
  EXPECT_NEAR(knocked->shift_px, std::hypot(3.3, 1.6), 0.2);
  EXPECT_TRUE(has_moved(*knocked));
  const auto turned = background_shift(before, wall(0, 0, 1.0, 4));
  ASSERT_TRUE(turned);
  EXPECT_NEAR(std::abs(turned->turn_deg), 1.0, 0.1);
  EXPECT_TRUE(has_moved(*turned));
}

// Things in one corner of a bare wall, under more noise than usual: the far side of the picture is only guessed.
cv::Mat corner_of_a_wall(unsigned seed) {
  cv::Mat picture(480, 640, CV_8UC1, cv::Scalar(80));
  cv::RNG things(5);
  for (int i = 0; i < 40; ++i)
    cv::rectangle(picture, cv::Rect(things.uniform(20, 180), things.uniform(20, 160), 10, 10),
                  cv::Scalar(things.uniform(30, 220)), cv::FILLED);
  cv::GaussianBlur(picture, picture, {}, 1.5);
  cv::Mat noise(picture.size(), CV_16SC1), noisy;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 4.0);
  picture.convertTo(noisy, CV_16SC1);
  noisy += noise;
  noisy.convertTo(picture, CV_8UC1);
  return picture;
}

TEST(CameraWatch, FeaturesCloseTogetherSayLittleOfTheRest) {
  int told = 0;
  for (unsigned seed = 1; seed <= 12; ++seed)
    if (const auto shift = background_shift(corner_of_a_wall(100 + seed), corner_of_a_wall(200 + seed))) {
      ++told;
      EXPECT_GT(shift->deviation_px, 0.1) << seed;
      EXPECT_FALSE(has_moved(*shift)) << seed << ": " << shift->shift_px << " +- " << shift->deviation_px;
    }
  EXPECT_GE(told, 3);
}

TEST(CameraWatch, SaysNothingOfAnEmptyWall) {
  EXPECT_FALSE(background_shift(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)), wall(0, 0, 0, 1)));
  EXPECT_THROW(background_shift(wall(0, 0, 0, 1), cv::Mat(10, 10, CV_8UC1)), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
