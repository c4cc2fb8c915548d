#include "capture/matte/empty_studio.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

// A blue wall, darker to one side, a grey floor, a black corner; noise that grows with brightness.
cv::Mat picture(cv::RNG& random, int person_at = -1) {
  cv::Mat rgb(120, 160, CV_8UC3, cv::Scalar(30, 60, 160));
  rgb.rowRange(90, 120).setTo(cv::Scalar(110, 112, 115));
  rgb(cv::Rect(0, 0, 20, 20)).setTo(cv::Scalar(2, 2, 2));
  for (int x = 0; x < rgb.cols; ++x) rgb.col(x) *= 1.0 - 0.4 * x / rgb.cols;
  if (person_at >= 0) rgb(cv::Rect(person_at, 30, 16, 70)).setTo(cv::Scalar(190, 150, 130));
  cv::Mat noise(rgb.size(), CV_32FC3), signal;
  rgb.convertTo(signal, CV_32F);
  random.fill(noise, cv::RNG::NORMAL, 0.0, 1.0);
  cv::Mat sigma;
  cv::sqrt(signal * 0.03 + 1.0, sigma);
  cv::Mat(signal + noise.mul(sigma)).convertTo(rgb, CV_8UC3);
  return rgb;
}

TEST(EmptyStudio, IsTheMeanWithTheNoiseAveragedAway) {
  cv::RNG random(3);
  EmptyStudioAverage average;
  for (int i = 0; i < 50; ++i) average.add(picture(random));
  const auto studio = average.result();
  EXPECT_EQ(studio.pictures, 50u);
  EXPECT_NEAR(studio.picture.at<cv::Vec3b>(60, 80)[2], 160.0 * 0.8, 2.0);
  EXPECT_GT(studio.noise, 1.0);
  EXPECT_LT(studio.noise, 2.5);
  EXPECT_LT(studio.moving_share, 0.001) << "noise of bright and dark parts is none";
}

TEST(EmptyStudio, SomebodyWhoWalksThroughIsTold) {
  cv::RNG random(4);
  EmptyStudioAverage average;
  for (int i = 0; i < 50; ++i) average.add(picture(random, 20 + 2 * i));
  EXPECT_GT(average.result().moving_share, 0.2);
}

TEST(EmptyStudio, EvenAHandIsTold) {
  cv::RNG random(5);
  EmptyStudioAverage average;
  for (int i = 0; i < 50; ++i) {
    cv::Mat rgb = picture(random);
    if (i > 25) rgb(cv::Rect(70, 40, 12, 12)).setTo(cv::Scalar(190, 150, 130));
    average.add(rgb);
  }
  EXPECT_NEAR(average.result().moving_share, 144.0 / (120 * 160), 0.001);
}

TEST(EmptyStudio, RefusesTooFewAndOtherSizes) {
  EmptyStudioAverage average;
  average.add(cv::Mat(10, 10, CV_8UC3, cv::Scalar::all(0)));
  EXPECT_THROW(average.result(), InvalidInput);
  EXPECT_THROW(average.add(cv::Mat(10, 11, CV_8UC3, cv::Scalar::all(0))), InvalidInput);
}

TEST(EmptyStudio, LetsGoWhatWouldOverflowItsSums) {
  EmptyStudioAverage average;
  for (int i = 0; i < 300; ++i) average.add(cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(255)));
  EXPECT_EQ(average.result().pictures, 256u);
  EXPECT_EQ(average.result().picture.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 255, 255));
}

}  // namespace
}  // namespace rotunda::capture
