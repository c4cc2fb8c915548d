#include "capture/picture_health.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

// Rectangles of all sizes and brightnesses before a wall: edges, as people and studios have them.
cv::Mat scene(double contrast = 1.0) {
  cv::Mat rgb(288, 360, CV_8UC3, cv::Scalar(60, 80, 130));
  cv::RNG random(7);
  for (int i = 0; i < 60; ++i) {
    const cv::Point at(random.uniform(0, 300), random.uniform(0, 250));
    const cv::Point to = at + cv::Point(random.uniform(4, 60), random.uniform(4, 40));
    const double level = 40.0 + contrast * random.uniform(0, 150);
    cv::rectangle(rgb, at, to, cv::Scalar::all(level), cv::FILLED);
  }
  return rgb;
}

cv::Mat blurred(const cv::Mat& rgb, double sigma) {
  cv::Mat out;
  cv::GaussianBlur(rgb, out, {}, sigma);
  return out;
}

cv::Mat noisy(const cv::Mat& rgb, double sigma) {
  cv::Mat noise(rgb.size(), CV_16SC3), sum;
  cv::theRNG().state = 11;
  cv::randn(noise, cv::Scalar::all(0), cv::Scalar::all(sigma));
  cv::add(rgb, noise, sum, cv::noArray(), CV_8UC3);
  return sum;
}

TEST(PictureHealth, FocusFallsWithBlur) {
  double before = 1.1;
  for (const double sigma : {0.5, 1.0, 2.0, 4.0}) {
    const double focus = picture_health(blurred(scene(), sigma)).focus;
    EXPECT_LT(focus, before - 0.05) << sigma;
    before = focus;
  }
  EXPECT_LT(before, 0.3);
}

TEST(PictureHealth, NeitherNoiseNorContrastPassesForFocus) {
  for (const double sigma : {0.5, 2.0}) {
    const double clean = picture_health(blurred(scene(), sigma)).focus;
    EXPECT_NEAR(picture_health(noisy(blurred(scene(), sigma), 3.0)).focus, clean, 0.12) << sigma;
    EXPECT_NEAR(picture_health(blurred(scene(0.5), sigma)).focus, clean, 0.12) << sigma;
  }
}

TEST(PictureHealth, ABareWallHasNone) {
  EXPECT_EQ(picture_health(cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(90))).focus, 0.0);
  EXPECT_LT(picture_health(noisy(cv::Mat(200, 200, CV_8UC3, cv::Scalar::all(90)), 4.0)).focus, 0.3);
  EXPECT_EQ(picture_health(cv::Mat()).focus, 0.0);
}

TEST(PictureHealth, CountsPixelsAtTheEndOfAnyChannel) {
  cv::Mat rgb(100, 100, CV_8UC3, cv::Scalar(10, 20, 30));
  rgb.colRange(0, 25).setTo(cv::Scalar(255, 20, 30));
  EXPECT_NEAR(picture_health(rgb).clipped, 0.25, 1e-9);
}

}  // namespace
}  // namespace rotunda::capture
