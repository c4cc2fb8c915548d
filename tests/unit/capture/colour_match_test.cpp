#include "capture/calibration/colour_match.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kNames = {"cam0", "cam1", "cam2", "cam3", "cam4"};

// What camera i makes of the light: gains up to 30 % apart, a filter that mixes channels by a few percent.
Eigen::Matrix3d camera_response(std::size_t i, double mixing) {
  const double s = static_cast<double>(i) - 2.0;
  Eigen::Matrix3d response = Eigen::Vector3d(1.0 + 0.08 * s, 1.0, 1.0 - 0.07 * s).asDiagonal();
  response(0, 1) = mixing * s;
  response(1, 2) = -mixing * s;
  response(2, 0) = 0.5 * mixing * s;
  return response * (1.0 + 0.06 * (i % 2 == 0 ? 1.0 : -1.0));
}

// Places of colours spread over a part of the cube, each seen by three neighbouring cameras, with noise and some lies.
std::vector<ColourSample> samples_of(bool grey, double mixing, double noise, int lies) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> spread(0.08, 0.6);
  std::normal_distribution<double> error(0.0, noise);
  std::vector<ColourSample> samples;
  for (std::size_t place = 0; place < 200; ++place) {
    Eigen::Vector3d light(spread(random), spread(random), spread(random));
    if (grey) light.setConstant(light[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t camera = (place + k) % kNames.size();
      Eigen::Vector3d seen = camera_response(camera, mixing) * light;
      for (int c = 0; c < 3; ++c) seen[c] *= 1.0 + error(random);
      if (static_cast<int>(place) < lies && k == 0) seen = Eigen::Vector3d(0.6, 0.1, 0.1);
      samples.push_back({camera, place, seen});
    }
  }
  return samples;
}

// The corrected responses are one response for all; up to that common one nothing can be known.
double worst_difference(const ColourMatch& match, double mixing) {
  double worst = 0.0;
  const Eigen::Matrix3d first = match.cameras[0].matrix * camera_response(0, mixing);
  for (std::size_t i = 1; i < kNames.size(); ++i)
    worst = std::max(worst, (match.cameras[i].matrix * camera_response(i, mixing) - first).cwiseAbs().maxCoeff());
  return worst;
}

TEST(ColourMatch, FindsTheMatricesThatMakeCamerasAgree) {
  const auto exact = samples_of(false, 0.03, 0.0, 0);
  const auto match = match_colours(kNames, exact);
  EXPECT_LT(worst_difference(match, 0.03), 2e-4);
  EXPECT_GT(match.before, 8.0);
  EXPECT_LT(match.after, 0.05);
  EXPECT_FALSE(match.cameras[2].gains_only);
}

TEST(ColourMatch, StandsNoiseAndPlacesThatLie) {
  const auto noisy = samples_of(false, 0.03, 0.02, 15);
  const auto match = match_colours(kNames, noisy);
  // 120 samples a camera with 2 % noise: about 0.02 / sqrt(120) on gains, some times that on what mixes.
  EXPECT_LT(worst_difference(match, 0.03), 0.025);
  EXPECT_LT(match.after, 0.35 * match.before);
}

TEST(ColourMatch, OfGreysIsGainsAlone) {
  const auto greys = samples_of(true, 0.0, 0.005, 0);
  const auto match = match_colours(kNames, greys);
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    EXPECT_TRUE(match.cameras[i].gains_only);
    EXPECT_LT(std::abs(match.cameras[i].matrix(0, 1)), 0.02) << i;
  }
  EXPECT_LT(worst_difference(match, 0.0), 0.02);
}

TEST(ColourMatch, ACameraWithNothingInCommonIsToldAndLeftAlone) {
  auto samples = samples_of(false, 0.03, 0.0, 0);
  std::erase_if(samples, [](const auto& sample) { return sample.camera == 4; });
  const auto match = match_colours(kNames, samples);
  ASSERT_EQ(match.advice.size(), 1U);
  EXPECT_THAT(match.advice[0], HasSubstr("cam4"));
  EXPECT_TRUE(match.cameras[4].matrix.isIdentity(0.0));
  EXPECT_LT(match.after, 0.05);
  EXPECT_THROW(match_colours(kNames, std::vector<ColourSample>(1)), InvalidInput);
}

TEST(Srgb, TheCurveGoesThereAndBack) {
  for (int code = 0; code < 256; ++code) EXPECT_EQ(srgb8_of(linear_table()[static_cast<std::size_t>(code)]), code);
  cv::Mat picture(1, 256, CV_8UC3);
  for (int code = 0; code < 256; ++code)
    picture.at<cv::Vec3b>(0, code) = cv::Vec3b::all(static_cast<std::uint8_t>(code));
  const cv::Mat darker = with_matrix(picture, Eigen::Matrix3d::Identity() * 0.5);
  EXPECT_EQ(with_matrix(picture, Eigen::Matrix3d::Identity() * 2.0).at<cv::Vec3b>(0, 255)[1], 255);
  for (int code = 0; code < 256; ++code) {
    const double exact = 255.0 * srgb_of_linear(0.5 * linear_table()[static_cast<std::size_t>(code)]);
    EXPECT_NEAR(darker.at<cv::Vec3b>(0, code)[0], exact, 1.0) << code;
  }
}

}  // namespace
}  // namespace rotunda::capture
