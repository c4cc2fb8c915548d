#include "recon/colour/visibility.h"

#include <gtest/gtest.h>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"

namespace rotunda::recon {
namespace {

const tests::Ball kBall{{0.1, -0.2, 1.0}, 0.4};

TriangleMesh ball_mesh(int rings = 60) {
  TriangleMesh mesh;
  tests::append_ball(kBall, rings, mesh);
  return mesh;
}

capture::CameraModel odd_camera() {
  return simulator::camera_layout(
      {.cameras = 2, .width = 200, .height = 160, .aspect = 16.0 / 15.0, .skew_px = 3.0, .k1 = -0.1})[0];
}

double true_depth(const capture::CameraModel& camera, double x, double y) {
  const Eigen::Vector3d direction = capture::ray_through(camera, {x, y}).value();
  return tests::distance_along(kBall, camera.centre(), direction) * direction.dot(camera.axis());
}

// Rings of 3 degrees lie at most 0.4 m * (1 - cos 1.5 degrees) = 0.14 mm inside the ball; seen at a slope, more.
void expect_the_ball(const DepthMap& map, const capture::CameraModel& camera) {
  int inner = 0;
  for (int y = 0; y < map.depth.rows; ++y)
    for (int x = 0; x < map.depth.cols; ++x) {
      const double u = (x + 0.5) * map.downscale - 0.5, v = (y + 0.5) * map.downscale - 0.5;
      const double truth = true_depth(camera, u, v), found = map.depth.at<float>(y, x);
      const auto distance = [&](double dx, double dy) { return true_depth(camera, u + dx, v + dy); };
      const bool near_outline = std::isfinite(distance(2, 0) + distance(-2, 0) + distance(0, 2) + distance(0, -2)) !=
                                (std::isfinite(distance(2, 0)) || std::isfinite(distance(-2, 0)));
      if (near_outline) continue;
      EXPECT_EQ(std::isfinite(found), std::isfinite(truth)) << u << ' ' << v;
      if (std::isfinite(truth)) {
        EXPECT_NEAR(found, truth, 2e-3);
      }
      inner += std::isfinite(truth);
    }
  EXPECT_GT(inner * map.downscale * map.downscale, 1000);
}

}  // namespace

TEST(Visibility, DrawsTheDepthOfABallThroughSkewAndDistortion) {
  expect_the_ball(render_depth(ball_mesh(), odd_camera()), odd_camera());
}

TEST(Visibility, ACoarserMapStandsInTheSamePlace) {
  const auto map = render_depth(ball_mesh(), odd_camera(), 2);
  EXPECT_EQ(map.depth.size(), cv::Size(100, 80));
  expect_the_ball(map, odd_camera());
}

TEST(Visibility, SeesAMirroredWorldAsTheTrueOne) {
  auto camera = odd_camera();
  auto mesh = ball_mesh();
  const auto truth = render_depth(mesh, camera);
  camera.R.col(2) *= -1.0;
  for (auto& position : mesh.positions) position.z() *= -1.0F;
  const auto mirrored = render_depth(mesh, camera);
  EXPECT_EQ(cv::countNonZero((truth.depth < 100) != (mirrored.depth < 100)), 0);
  cv::Mat both = truth.depth < 100;
  EXPECT_LT(cv::norm(truth.depth, mirrored.depth, cv::NORM_INF, both), 1e-5);
}

TEST(Visibility, LeavesOutWhatLiesBehindTheCameraOrNowhere) {
  const auto camera = odd_camera();
  TriangleMesh mesh;
  const Eigen::Vector3f behind = (camera.centre() - camera.axis()).cast<float>();
  mesh.positions = {behind, behind + Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 0, 1),
                    Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN())};
  mesh.triangles = {{0, 1, 2}, {1, 2, 3}, {2, 2, 2}};
  EXPECT_EQ(cv::countNonZero(render_depth(mesh, camera).depth < 1e6F), 0);
  EXPECT_THROW(render_depth(mesh, camera, 0), InvalidInput);
  EXPECT_THROW(render_depth(mesh, capture::CameraModel{}), InvalidInput);
}

}  // namespace rotunda::recon
