#include "simulator/studio/lens.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "simulator/studio/camera_layout.h"

namespace rotunda::simulator {
namespace {

capture::CameraModel camera() {
  return camera_layout({.cameras = 2, .width = 360, .height = 288}).front();
}

// Where the light of a channel lies, from the picture's middle of light.
Eigen::Vector2d centroid(const cv::Mat& linear, int channel) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double all = 0.0;
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const double light = static_cast<double>(linear.at<cv::Vec3f>(y, x)[channel]);
      sum += light * Eigen::Vector2d(x, y);
      all += light;
    }
  return sum / all;
}

const SensorOptions kColourful{.lateral_colour_px = 2.0};

TEST(Lens, RedLiesFartherOutByWhatTheTruthTells) {
  const auto model = camera();
  const auto lens = lens_flaws(model, 1, kColourful);
  EXPECT_GT(lens.red_scale, 1.0);
  EXPECT_LT(lens.blue_scale, 1.0);
  const Eigen::Vector2d place(300.0, 240.0), out = place - Eigen::Vector2d(lens.centre.x, lens.centre.y);
  cv::Mat linear(288, 360, CV_32FC3, cv::Scalar::all(0.0));
  cv::rectangle(linear, {295, 235, 11, 11}, cv::Scalar::all(1.0), cv::FILLED);
  look_through(lens, linear);
  EXPECT_NEAR((centroid(linear, 1) - place).norm(), 0.0, 0.01);
  EXPECT_NEAR((centroid(linear, 0) - place - (lens.red_scale - 1.0) * out).norm(), 0.0, 0.03);
  EXPECT_NEAR((centroid(linear, 2) - place - (lens.blue_scale - 1.0) * out).norm(), 0.0, 0.03);
}

// A figure in front of the backdrop is shifted as the backdrop is: grey before equal grey stays unseen.
TEST(Lens, FiguresAndBackdropShiftAlike) {
  const auto model = camera();
  const auto lens = lens_flaws(model, 0, kColourful);
  cv::Mat with(288, 360, CV_32FC3, cv::Scalar::all(0.4)), matte(288, 360, CV_8UC1, cv::Scalar(0));
  look_through(lens, with);
  FigureLayer layer{{280, 200, 40, 40}, cv::Mat(40, 40, CV_32FC4, cv::Scalar::all(0.0))};
  cv::rectangle(layer.rgba, {10, 10, 20, 20}, {0.4, 0.4, 0.4, 1.0}, cv::FILLED);
  lay_figures(lens, layer, with, matte);
  cv::Mat plain(288, 360, CV_32FC3, cv::Scalar::all(0.4));
  EXPECT_LT(cv::norm(with, plain, cv::NORM_INF), 1e-5);
  EXPECT_EQ(matte.at<std::uint8_t>(220, 300), 255);
  EXPECT_EQ(matte.at<std::uint8_t>(190, 300), 0);
}

TEST(Lens, CamerasDifferAndAPerfectLensChangesNothing) {
  const auto model = camera();
  EXPECT_NE(lens_flaws(model, 0, {}).blur_px, lens_flaws(model, 1, {}).blur_px);
  const SensorOptions perfect{.lens_blur_px = 0.0, .lateral_colour_px = 0.0};
  EXPECT_FALSE(lens_flaws(model, 0, perfect).has_colour());
  cv::Mat linear(288, 360, CV_32FC3), before;
  cv::randu(linear, 0.0, 1.0);
  linear.copyTo(before);
  look_through(lens_flaws(model, 0, perfect), linear);
  EXPECT_EQ(cv::norm(linear, before, cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace rotunda::simulator
