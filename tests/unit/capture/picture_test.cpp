#include "capture/picture.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>

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

}  // namespace
}  // namespace rotunda::capture
