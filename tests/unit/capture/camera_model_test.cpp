#include "capture/camera_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>

namespace rotunda::capture {
namespace {

// Skewed, fx != fy, with a lens that moves the corners by tens of pixels.
CameraModel strong_camera() {
  CameraModel camera;
  camera.name = "cam00";
  camera.width = 320;
  camera.height = 240;
  camera.K << 260.0, 4.0, 163.0, 0, 277.0, 118.0, 0, 0, 1;
  camera.distortion << -0.25, 0.06, 0.002, -0.003, 0.004;
  camera.R = Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, -0.9, 0.3).normalized()).toRotationMatrix();
  camera.t << 0.2, -0.1, 3.0;
  return camera;
}

}  // namespace

TEST(CameraModel, ProjectsSkewAsTheMatrixSays) {
  CameraModel camera = strong_camera();
  camera.distortion.setZero();
  const Eigen::Vector3d point(0.3, -0.4, 0.5);
  const Eigen::Vector3d expected = camera.K * (camera.R * point + camera.t);
  const auto pixel = project(camera, point);
  ASSERT_TRUE(pixel);
  EXPECT_LT((*pixel - expected.hnormalized()).norm(), 1e-12);
  camera.K(0, 1) = 0.0;
  EXPECT_GT(std::abs(pixel->x() - project(camera, point)->x()), 0.1);  // skew is not ignored
}

TEST(CameraModel, DistortsLikeOpenCvWhereThatKnowsAll) {
  CameraModel camera = strong_camera();
  camera.K(0, 1) = 0.0;
  cv::Mat K(3, 3, CV_64F), distortion(1, 5, CV_64F), R(3, 3, CV_64F), rotation;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) K.at<double>(i, j) = camera.K(i, j), R.at<double>(i, j) = camera.R(i, j);
  for (int i = 0; i < 5; ++i) distortion.at<double>(i) = camera.distortion[i];
  cv::Rodrigues(R, rotation);
  const std::vector<cv::Point3d> points{{0, 0, 0}, {0.6, 0.4, 0.2}, {-0.7, -0.5, 0.4}};
  std::vector<cv::Point2d> expected;
  cv::projectPoints(points, rotation, cv::Vec3d(camera.t.x(), camera.t.y(), camera.t.z()), K, distortion, expected);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = project(camera, {points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), expected[i].x, 1e-9);
    EXPECT_NEAR(pixel->y(), expected[i].y, 1e-9);
  }
}

TEST(CameraModel, RaysGoThroughThePointsThatProjectThere) {
  const CameraModel camera = strong_camera();
  for (double x = -0.5; x < 320; x += 20)
    for (double y = -0.5; y < 240; y += 20) {
      const auto ray = ray_through(camera, {x, y});
      ASSERT_TRUE(ray) << x << ' ' << y;
      EXPECT_NEAR(ray->norm(), 1.0, 1e-12);
      const auto back = project(camera, camera.centre() + 2.5 * *ray);
      ASSERT_TRUE(back) << x << ' ' << y;
      EXPECT_LT((*back - Eigen::Vector2d(x, y)).norm(), 1e-6);
    }
}

TEST(CameraModel, HasNothingBeyondTheFoldOfItsLens) {
  CameraModel camera = strong_camera();
  camera.distortion << -0.4, 0, 0, 0, 0;  // r (1 - 0.4 r^2) turns back at r = sqrt(1 / 1.2) = 0.913
  camera.R.setIdentity();
  camera.t.setZero();
  EXPECT_TRUE(project(camera, {0.90, 0, 1}));
  EXPECT_FALSE(project(camera, {0.93, 0, 1}));
  EXPECT_FALSE(project(camera, {1.6, 0, 1}));  // folded back, it would land near the middle
  EXPECT_FALSE(undistort(camera, {0.7, 0}));   // beyond the fold's 0.609: no ray ends there
  EXPECT_FALSE(ray_through(camera, {163 + 0.7 * 260, 118}));
}

TEST(CameraModel, SeesNothingBehindItself) {
  CameraModel camera = strong_camera();
  EXPECT_FALSE(project(camera, camera.centre()));
  EXPECT_FALSE(project(camera, camera.centre() - camera.axis()));
  EXPECT_TRUE(project(camera, camera.centre() + camera.axis()));
}

TEST(CameraModel, UndistortedImagesShowEveryPointWhereThePinholePutsIt) {
  const CameraModel camera = strong_camera();
  // The picture of a scene whose colour is the place in the ideal picture: column in red, row in green.
  cv::Mat picture(camera.height, camera.width, CV_32FC2);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = camera.R * ray_through(camera, {x, y}).value();
      const Eigen::Vector2d ideal = (camera.K * ray).hnormalized();
      picture.at<cv::Vec2f>(y, x) = {static_cast<float>(ideal.x()), static_cast<float>(ideal.y())};
    }
  const cv::Mat straight = undistort_image(camera, picture, cv::Scalar::all(-1e6));
  int seen = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto& found = straight.at<cv::Vec2f>(y, x);
      if (found[0] < -1e3F) continue;  // outside of the picture
      ++seen;
      EXPECT_NEAR(found[0], x, 0.05);  // remap's table has 32 steps a pixel
      EXPECT_NEAR(found[1], y, 0.05);
    }
  EXPECT_GT(seen, camera.width * camera.height * 9 / 10);
  EXPECT_TRUE(without_distortion(camera).distortion.isZero(0.0));
  EXPECT_EQ(without_distortion(camera).K, camera.K);
}

}  // namespace rotunda::capture
