// A ball in free flight before the studio's cameras: where it is seen, how its motion smears, what shade it throws.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "simulator/people/performance.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/light.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

recon::TriangleMesh ball_at(const Vector3d& centre, double radius) {
  constexpr int kRings = 16, kSpokes = 32;
  recon::TriangleMesh mesh;
  const auto add = [&](const Vector3d& normal) {
    mesh.normals.push_back(normal.cast<float>());
    mesh.positions.push_back((centre + radius * normal).cast<float>());
    mesh.colours.push_back({200, 180, 160});
  };
  add(Vector3d::UnitZ());
  for (int ring = 1; ring < kRings; ++ring)
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const double down = std::numbers::pi * ring / kRings, around = 2.0 * std::numbers::pi * spoke / kSpokes;
      add({std::sin(down) * std::cos(around), std::sin(down) * std::sin(around), std::cos(down)});
    }
  add(-Vector3d::UnitZ());
  const auto index = [](int ring, int spoke) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * kSpokes + spoke % kSpokes);
  };
  const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  for (int spoke = 0; spoke < kSpokes; ++spoke) {
    mesh.triangles.push_back({0, index(1, spoke), index(1, spoke + 1)});
    mesh.triangles.push_back({last, index(kRings - 1, spoke + 1), index(kRings - 1, spoke)});
    for (int ring = 1; ring + 1 < kRings; ++ring) {
      mesh.triangles.push_back({index(ring, spoke), index(ring + 1, spoke), index(ring + 1, spoke + 1)});
      mesh.triangles.push_back({index(ring, spoke), index(ring + 1, spoke + 1), index(ring, spoke + 1)});
    }
  }
  return mesh;
}

// Balls that fly straight on.
class Balls final : public Performance {
 public:
  Balls(std::vector<Vector3d> places, double radius, Vector3d speed)
      : places_(std::move(places)), radius_(radius), speed_(std::move(speed)) {
    for (const auto& place : places_) {
      Figure figure{ball_at(place, radius_), {}, {cv::Mat(4, 4, CV_8UC3, cv::Scalar(200, 180, 160)), {}}};
      figure.openness.assign(figure.bind.positions.size(), 1.0F);
      figure.texture.corners.assign(3 * figure.bind.triangles.size(), Eigen::Vector2f(2.0F, 2.0F));
      figures_.push_back(std::move(figure));
    }
  }
  const std::string& person() const override { return name_; }
  const std::string& act() const override { return name_; }
  int frames() const override { return 10; }
  bool is_cyclic() const override { return false; }
  const std::vector<Figure>& figures() const override { return figures_; }
  std::vector<recon::TriangleMesh> surfaces_at(double seconds) const override {
    std::vector<recon::TriangleMesh> surfaces;
    for (const auto& place : places_) surfaces.push_back(ball_at(place + (seconds - 0.2) * speed_, radius_));
    return surfaces;
  }
  const std::vector<JointInfo>& joints() const override { return joints_; }
  std::vector<JointState> joints_at(double) const override { return {}; }
  std::vector<HeelStrike> heel_strikes() const override { return {}; }
  std::string fingerprint() const override { return name_; }

 private:
  std::vector<Vector3d> places_;
  double radius_;
  Vector3d speed_;
  std::string name_ = "balls";
  std::vector<Figure> figures_;
  std::vector<JointInfo> joints_;
};

struct Spot {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double across = 0.0;  // variance along x, pixels
};

Spot spot_near(const cv::Mat& matte, const Eigen::Vector2d& at, int reach) {
  double sum = 0.0, xx = 0.0;
  Spot spot;
  for (int y = std::max(0, cvRound(at.y()) - reach); y <= std::min(matte.rows - 1, cvRound(at.y()) + reach); ++y)
    for (int x = std::max(0, cvRound(at.x()) - reach); x <= std::min(matte.cols - 1, cvRound(at.x()) + reach); ++x) {
      const double cover = matte.at<std::uint8_t>(y, x);
      sum += cover;
      spot.middle += cover * Eigen::Vector2d(x, y);
      xx += cover * x * x;
    }
  spot.middle /= sum;
  spot.across = xx / sum - spot.middle.x() * spot.middle.x();
  return spot;
}

capture::CameraModel front_camera() {
  auto camera = camera_layout({.cameras = 2, .width = 360, .height = 288})[0];
  camera.distortion.setZero();
  return camera;
}

// The whole lens: k1, k2, p1, p2, k3 and skew, far out in the picture where they differ by many pixels.
TEST(SceneRenderer, ABallIsSeenWhereTheCameraModelProjectsIt) {
  auto camera = front_camera();
  camera.K(0, 1) = 2.5;
  camera.distortion << -0.25, 0.12, 0.004, -0.003, -0.05;
  std::vector<Vector3d> places;
  for (const double y : {-0.9, -0.3, 0.8})
    for (const double z : {0.3, 1.0, 1.7}) places.emplace_back(0.0, y, z);
  const Balls balls(places, 0.03, Vector3d::Zero());
  SceneRenderer studio(balls, {camera});
  const auto matte = studio.picture(0, 0.2, 1).matte;
  double moved = 0.0;
  for (const auto& place : places) {
    const auto expected = *capture::project(camera, place);
    const auto straight = *capture::project(capture::without_distortion(camera), place);
    moved = std::max(moved, (expected - straight).norm());
    const auto spot = spot_near(matte, expected, 9);
    EXPECT_NEAR((spot.middle - expected).norm(), 0.0, 0.05) << place.transpose();
  }
  EXPECT_GT(moved, 3.0);
}

// Seen moving for the exposure, a spot's variance along its way grows by way^2 / 12, and its middle stays.
TEST(SceneRenderer, MotionSmearsBySpeedTimesExposure) {
  const auto camera = front_camera();
  const Vector3d speed(0.0, 6.0, 0.0);
  const Balls still({{0.0, 0.0, 1.0}}, 0.1, Vector3d::Zero()), flying({{0.0, 0.0, 1.0}}, 0.1, speed);
  const auto expected = *capture::project(camera, Vector3d(0.0, 0.0, 1.0));
  SceneRenderer at_rest(still, {camera});
  const auto sharp = spot_near(at_rest.picture(0, 0.2, 1).matte, expected, 60);
  for (const double exposure : {0.005, 0.010}) {
    SceneRenderer in_flight(flying, {camera}, {.cameras = {{.exposure_s = exposure}}});
    const auto smeared = spot_near(in_flight.picture(0, 0.2, 1).matte, expected, 60);
    const double way =
        std::abs(capture::project(camera, Vector3d(0.0, 0.0, 1.0) + exposure * speed)->x() - expected.x());
    ASSERT_GT(way, 2.0);
    EXPECT_NEAR(std::sqrt(12.0 * (smeared.across - sharp.across)), way, 0.12 * way);  // 4 or 8 moments: 3 % or less
    EXPECT_NEAR((smeared.middle - expected).norm(), 0.0, 0.06);
  }
}

TEST(SceneRenderer, IsTheSameOnOneAndManyThreads) {
  const Balls balls({{0.0, 0.0, 1.0}}, 0.3, {0.0, 2.0, 0.0});
  auto cameras = camera_layout({.cameras = 3, .width = 160, .height = 128});
  SceneRenderer studio(balls, cameras);
  const auto many = studio.pictures(0.2, 4);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = studio.pictures(0.2, 4);
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    EXPECT_EQ(cv::norm(many[camera].deep, alone[camera].deep, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(many[camera].deep, studio.picture(camera, 0.2, 4).deep, cv::NORM_INF), 0.0);
  }
}

TEST(ShadowMaps, ABallShadesTheFloorBelowItAndItsOwnUnderside) {
  const auto ball = ball_at({0.0, 0.0, 0.35}, 0.3);
  const ShadowMaps maps({ball});
  const auto floor = [&](double x) {
    const Vector3f p(static_cast<float>(x), 0.0F, 0.0F);
    return floor_light(p, maps.at(p, Vector3f::UnitZ()));
  };
  EXPECT_LT(floor(0.0), 0.35F);
  EXPECT_GT(floor(0.5), floor(0.1) + 0.1F);  // it fades outwards
  EXPECT_GT(floor(1.6), 0.97F);
  const auto top = maps.at({0.0F, 0.0F, 0.65F}, Vector3f::UnitZ());
  for (const float lamp : top.lamps) EXPECT_GT(lamp, 0.9F);
  const auto below = maps.at({0.0F, 0.0F, 0.05F}, -Vector3f::UnitZ());
  EXPECT_LT(below.surroundings, 0.5F * top.surroundings);
}

}  // namespace
}  // namespace rotunda::simulator
