#include "recon/hull/signed_silhouette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

// Coverage of a disc, by 16 x 16 samples a pixel.
capture::Matte disc(double cx, double cy, double radius, int side = 96) {
  capture::Matte matte{cv::Mat::zeros(side, side, CV_8UC1)};
  constexpr int kSamples = 16;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      int inside = 0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double px = x - 0.5 + (s % kSamples + 0.5) / kSamples, py = y - 0.5 + (s / kSamples + 0.5) / kSamples;
        inside += std::hypot(px - cx, py - cy) < radius ? 1 : 0;
      }
      matte.alpha.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0 * inside / (kSamples * kSamples));
    }
  return matte;
}

TEST(SignedSilhouette, IsSubPixelAndUnbiasedAroundADisc) {
  for (const double radius : {20.0, 20.3, 20.5, 20.85}) {
    const auto distance = signed_silhouette(disc(47.37, 48.12, radius));
    double sum = 0.0, worst = 0.0;
    int count = 0;
    for (int y = 0; y < distance.rows; ++y)
      for (int x = 0; x < distance.cols; ++x) {
        const double truth = radius - std::hypot(x - 47.37, y - 48.12);
        if (std::abs(truth) > 4.0) continue;
        const double error = static_cast<double>(distance.at<float>(y, x)) - truth;
        sum += error;
        worst = std::max(worst, std::abs(error));
        ++count;
      }
    EXPECT_NEAR(sum / count, 0.0, 0.02) << radius;  // linear interpolation of coverage errs by 0.09 at most, both ways
    EXPECT_LT(worst, 0.15) << radius;
  }
}

TEST(SignedSilhouette, FarDistancesAreWithinAPixel) {
  const auto distance = signed_silhouette(disc(47.0, 48.0, 20.0));
  EXPECT_NEAR(static_cast<double>(distance.at<float>(48, 47)), 20.0, 1.0);
  EXPECT_NEAR(static_cast<double>(distance.at<float>(48, 7)), -20.0, 1.0);
}

TEST(SignedSilhouette, ThePicturesBorderIsNoOutline) {
  capture::Matte matte{cv::Mat::zeros(40, 60, CV_8UC1)};
  matte.alpha.colRange(0, 30).setTo(255);  // the body reaches the left, top and bottom border
  const auto distance = signed_silhouette(matte);
  EXPECT_NEAR(static_cast<double>(distance.at<float>(20, 0)), 29.5, 1e-3);
  EXPECT_NEAR(static_cast<double>(distance.at<float>(0, 0)), 29.5, 1e-3);
}

TEST(SignedSilhouette, FullAndEmptyMattesHaveOneSignAndNoInfinity) {
  const cv::Mat full(20, 30, CV_8UC1, cv::Scalar(255)), empty = cv::Mat::zeros(20, 30, CV_8UC1);
  EXPECT_TRUE(cv::checkRange(signed_silhouette({full}), true, nullptr, 1.0, 1000.0));
  EXPECT_TRUE(cv::checkRange(signed_silhouette({empty}), true, nullptr, -1000.0, -1.0));
  EXPECT_TRUE(is_empty({empty}));
  EXPECT_FALSE(is_empty({full}));
}

TEST(SignedSilhouette, RefusesWhatIsNoMatte) {
  EXPECT_THROW(signed_silhouette({}), InvalidInput);
  EXPECT_THROW(signed_silhouette({cv::Mat::zeros(4, 4, CV_8UC3)}), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
