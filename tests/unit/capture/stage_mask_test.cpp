#include "capture/matte/stage_mask.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace rotunda::capture {
namespace {

CameraModel camera_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& target) {
  CameraModel camera;
  camera.width = 160;
  camera.height = 120;
  camera.K << 120, 0.4, 79, 0, 125, 61, 0, 0, 1;
  camera.distortion << -0.1, 0.02, 0.001, 0, 0;
  const Eigen::Vector3d forward = (target - centre).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  camera.R << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  camera.t = -camera.R * centre;
  return camera;
}

const Eigen::AlignedBox3d kVolume{Eigen::Vector3d(-0.5, -0.4, 0.0), Eigen::Vector3d(0.5, 0.4, 1.2)};

}  // namespace

TEST(StageMask, HoldsEveryPointOfTheVolume) {
  const auto camera = camera_at({3.0, 0.4, 1.1}, {0.0, 0.0, 0.6});
  const cv::Mat mask = stage_mask(camera, kVolume, 0);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d at(unit(random), unit(random), unit(random));
    const auto pixel = project(camera, kVolume.min() + at.cwiseProduct(kVolume.sizes()));
    ASSERT_TRUE(pixel);
    EXPECT_EQ(
        mask.at<std::uint8_t>(static_cast<int>(std::lround(pixel->y())), static_cast<int>(std::lround(pixel->x()))),
        255);
  }
}

// 8 pixels: two rays of the coarse raster each way.
TEST(StageMask, LeavesOutWhatNoRayToTheVolumePasses) {
  const auto camera = camera_at({3.0, 0.4, 1.1}, {0.0, 0.0, 0.6});
  const cv::Mat mask = stage_mask(camera, kVolume, 0);
  cv::Mat near = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (double x = 0.0; x <= 1.0; x += 0.02)
    for (double y = 0.0; y <= 1.0; y += 0.02)
      for (double z = 0.0; z <= 1.0; z += 0.02) {
        const auto pixel = project(camera, kVolume.min() + Eigen::Vector3d(x, y, z).cwiseProduct(kVolume.sizes()));
        const cv::Rect around(static_cast<int>(pixel->x()) - 10, static_cast<int>(pixel->y()) - 10, 21, 21);
        near(around & cv::Rect({}, near.size())).setTo(255);
      }
  EXPECT_EQ(cv::countNonZero(mask & ~near), 0);
  EXPECT_LT(cv::countNonZero(mask), 0.6 * static_cast<double>(mask.total()));
}

TEST(StageMask, IsEmptyForACameraThatLooksAwayAndFullInsideTheVolume) {
  EXPECT_EQ(cv::countNonZero(stage_mask(camera_at({3.0, 0.0, 1.0}, {6.0, 0.0, 1.0}), kVolume)), 0);
  const auto inside = stage_mask(camera_at({0.1, 0.0, 0.5}, {1.0, 0.1, 0.5}), kVolume);
  EXPECT_EQ(cv::countNonZero(inside), static_cast<int>(inside.total()));
}

}  // namespace rotunda::capture
