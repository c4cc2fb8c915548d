#include "recon/hull/matte_support.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

const tests::CapsuleBody kBody{{{0.0, 0.0, 0.2}, {0.0, 0.0, 1.5}, 0.14}, {{0.0, 0.0, 1.2}, {0.45, 0.0, 1.2}, 0.05}};
const Eigen::AlignedBox3d kVolume{Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(1, 1, 2)};

capture::CameraModel camera_at(double azimuth) {
  capture::CameraModel camera;
  camera.name = "cam";
  camera.width = 160;
  camera.height = 120;
  camera.K << 150, 0, 80, 0, 150, 60, 0, 0, 1;
  const Eigen::Vector3d centre(3.0 * std::cos(azimuth), 3.0 * std::sin(azimuth), 1.2), target(0.0, 0.0, 0.9);
  const Eigen::Vector3d forward = (target - centre).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  camera.R << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  camera.t = -camera.R * centre;
  return camera;
}

std::vector<capture::CameraModel> ring(int count) {
  std::vector<capture::CameraModel> cameras;
  for (int i = 0; i < count; ++i) cameras.push_back(camera_at(2.0 * std::numbers::pi * i / count));
  return cameras;
}

bool is_same(const cv::Mat& a, const cv::Mat& b) {
  return cv::countNonZero(a != b) == 0;
}

}  // namespace

TEST(MatteSupport, LeavesMattesThatAgreeAsTheyAre) {
  const auto cameras = ring(6);
  const auto mattes = tests::mattes_of(kBody, cameras);
  const auto supported = supported_mattes(cameras, mattes, {.bounds = kVolume});
  for (std::size_t i = 0; i < mattes.size(); ++i) EXPECT_TRUE(is_same(supported.mattes[i].alpha, mattes[i].alpha)) << i;
  EXPECT_TRUE(supported.disagreeing.empty());
}

TEST(MatteSupport, DropsAPieceThatNoOtherViewHas) {
  const auto cameras = ring(6);
  auto mattes = tests::mattes_of(kBody, cameras);
  const cv::Mat before = mattes[2].alpha.clone();
  cv::circle(mattes[2].alpha, {22, 30}, 6, 255, cv::FILLED);
  const auto supported = supported_mattes(cameras, mattes, {.bounds = kVolume});
  EXPECT_TRUE(is_same(supported.mattes[2].alpha, before));
  EXPECT_GT(supported.dropped[2], 0.0);
  const SilhouetteView fresh(cameras[2], {before});
  EXPECT_EQ(cv::norm(supported.views[2].distance_px(), fresh.distance_px(), cv::NORM_INF), 0.0);
  const auto kept =
      supported_mattes(cameras, mattes, {.bounds = kVolume, .keep = {false, false, true, false, false, false}});
  EXPECT_TRUE(is_same(kept.mattes[2].alpha, mattes[2].alpha));  // somebody gave it
}

TEST(MatteSupport, OneViewThatLostAnArmOrAllCostsTheOthersNothing) {
  const auto cameras = ring(6);
  const auto whole = tests::mattes_of(kBody, cameras);
  const auto armless = tests::matte_of({kBody.front()}, cameras[1]).alpha;
  for (const auto& lost : {armless, cv::Mat(cv::Mat::zeros(armless.size(), CV_8UC1))}) {
    auto mattes = whole;
    mattes[1].alpha = lost;
    const auto supported = supported_mattes(cameras, mattes, {.bounds = kVolume});
    for (std::size_t i = 0; i < mattes.size(); ++i)
      EXPECT_TRUE(is_same(supported.mattes[i].alpha, mattes[i].alpha)) << i;
  }
}

TEST(MatteSupport, DecidesNothingWhereViewsDisagree) {
  auto cameras = ring(6);
  const auto mattes = tests::mattes_of(kBody, cameras);
  cameras[3].t += cameras[3].R * Eigen::Vector3d(0.0, 0.6, 0.0);  // moved since it was calibrated
  const auto supported = supported_mattes(cameras, mattes, {.bounds = kVolume});
  EXPECT_TRUE(is_same(supported.mattes[3].alpha, mattes[3].alpha));
  EXPECT_EQ(supported.disagreeing, std::vector<std::size_t>{3});
  const std::vector<capture::CameraModel> three(cameras.begin(), cameras.begin() + 3);
  const auto few = supported_mattes(three, std::span(mattes).first(3), {.bounds = kVolume});
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(is_same(few.mattes[i].alpha, mattes[i].alpha));
}

TEST(MatteSupport, RefusesMattesOfAnotherNumber) {
  EXPECT_THROW(supported_mattes(ring(4), {}, {.bounds = kVolume}), InvalidInput);
  const auto mattes = tests::mattes_of(kBody, ring(4));
  EXPECT_THROW(supported_mattes(ring(4), mattes, {.bounds = kVolume, .keep = {true}}), InvalidInput);
}

}  // namespace rotunda::recon
