#include "recon/colour/surface_colour.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"

namespace rotunda::recon {
namespace {

using tests::Ball;

const cv::Vec3f kBlue(30, 60, 190);

struct Scene {
  std::vector<Ball> balls;
  TriangleMesh mesh;
  std::vector<ColourView> views;
};

template <class ColourOf>
Scene scene_of(std::vector<Ball> balls, const std::vector<capture::CameraModel>& cameras, const ColourOf& colour) {
  Scene scene{std::move(balls), {}, {}};
  for (const auto& ball : scene.balls) tests::append_ball(ball, 30, scene.mesh);
  for (const auto& camera : cameras) {
    auto picture = tests::picture_of(camera, scene.balls, kBlue, colour);
    scene.views.push_back({camera, picture.rgb, {picture.alpha}});
  }
  return scene;
}

std::vector<capture::CameraModel> small_rig(int cameras = 5) {
  return simulator::camera_layout(
      {.cameras = cameras, .width = 160, .height = 128, .aspect = 16.0 / 15.0, .skew_px = 2.0});
}

SurfaceColour colours_of(const Scene& scene, const SurfaceColourOptions& options = {}) {
  return surface_colour(scene.mesh.positions, scene.mesh.normals, scene.mesh, scene.views, options);
}

// A paint that changes smoothly over the ball, without blue.
cv::Vec3f paint(std::size_t, const Eigen::Vector3d& point) {
  return {static_cast<float>(150 + 90 * std::sin(1.5 * point.x())),
          static_cast<float>(130 + 70 * std::sin(2.0 * point.z() + 1.0)), 40.0F};
}

double worst_difference(const Colour& found, const cv::Vec3f& truth) {
  double worst = 0.0;
  for (int c = 0; c < 3; ++c)
    worst = std::max(worst, std::abs(double(found[static_cast<std::size_t>(c)]) - double(truth[c])));
  return worst;
}

// Of the view that faces the vertex most.
double best_cosine(const Scene& scene, std::size_t vertex) {
  double best = -1.0;
  for (const auto& view : scene.views)
    best = std::max(best, (view.camera.centre() - scene.mesh.positions[vertex].cast<double>())
                              .normalized()
                              .dot(scene.mesh.normals[vertex].cast<double>()));
  return best;
}

const std::vector<Ball> kOneBall{{{0.0, 0.1, 1.0}, 0.5}};

}  // namespace

TEST(SurfaceColour, FindsThePaintOfABallFromAllAround) {
  const auto scene = scene_of(kOneBall, small_rig(), paint);
  const auto found = colours_of(scene);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < found.colours.size(); ++i) {
    if (!found.coverage[i]) continue;
    ++seen;
    // The paint changes by 140 levels a metre, 2.5 a pixel of 18 mm across. A rim takes its colour from 3 pixels
    // inside, which on this ball of 28 pixels lies 0.2 m further along the surface.
    const double facing = best_cosine(scene, i);
    EXPECT_LT(worst_difference(found.colours[i], paint(0, scene.mesh.positions[i].cast<double>())),
              facing > 0.6 ? 6.0 : 30.0);
  }
  EXPECT_GT(seen, found.colours.size() * 4 / 5);  // the underside faces away from all
}

TEST(SurfaceColour, LetsNoBackdropBleedIn) {
  const auto scene = scene_of(kOneBall, small_rig(3), [](auto, const auto&) { return cv::Vec3f(180, 120, 60); });
  const auto found = colours_of(scene);
  for (std::size_t i = 0; i < found.colours.size(); ++i)
    if (found.coverage[i]) {
      EXPECT_LE(int(found.colours[i][2]), 75) << i;  // backdrop 190, a mixed pixel 125
    }
}

TEST(SurfaceColour, KeepsBlueClothesBlue) {
  const cv::Vec3f cloth(40, 50, 150);
  const auto scene = scene_of(kOneBall, small_rig(), [&](auto, const auto&) { return cloth; });
  const auto found = colours_of(scene);
  for (std::size_t i = 0; i < found.colours.size(); ++i)
    if (found.coverage[i]) {
      EXPECT_LT(worst_difference(found.colours[i], cloth), 8.0);
    }
}

TEST(SurfaceColour, TakesNoColourThroughWhatStandsInFront) {
  const auto cameras = small_rig(2);
  const Eigen::Vector3d back(0, 0, 1);
  const Eigen::Vector3d front = back + 0.9 * (cameras[0].centre() - back).normalized();
  const auto scene = scene_of(
      {{back, 0.4}, {front, 0.15}}, {cameras[0], cameras[1]},
      [](std::size_t ball, const auto&) { return ball == 0 ? cv::Vec3f(60, 160, 50) : cv::Vec3f(220, 40, 40); });
  const auto found = colours_of(scene);
  std::size_t hidden = 0;
  const Ball small{front, 0.15};
  for (std::size_t i = 0; i < scene.mesh.positions.size() / 2; ++i) {  // the big ball's
    if (found.coverage[i]) {
      EXPECT_LT(worst_difference(found.colours[i], {60, 160, 50}), 20.0);  // of 160: an eighth of a pixel
    }
    const Eigen::Vector3d to = scene.mesh.positions[i].cast<double>() - cameras[0].centre();
    const bool facing = to.dot(scene.mesh.normals[i].cast<double>()) < -0.3 * to.norm();
    if (!facing || !std::isfinite(tests::distance_along(small, cameras[0].centre(), to.normalized()))) continue;
    ++hidden;
  }
  EXPECT_GT(hidden, 40U);  // or the test shows nothing
}

TEST(SurfaceColour, SaysWhatNoViewSees) {
  const auto cameras = small_rig();
  const auto scene = scene_of(kOneBall, {cameras[0]}, paint);
  const auto found = colours_of(scene);
  for (std::size_t i = 0; i < found.colours.size(); ++i) {
    const Eigen::Vector3d point = scene.mesh.positions[i].cast<double>();
    const double cosine = (cameras[0].centre() - point).normalized().dot(scene.mesh.normals[i].cast<double>());
    if (cosine < 0.0) {
      EXPECT_EQ(int(found.coverage[i]), 0);
    }
    if (cosine > 0.4) {
      EXPECT_EQ(int(found.coverage[i]), 255);
    }
  }
  EXPECT_EQ(surface_colour(scene.mesh.positions, scene.mesh.normals, scene.mesh, {}).coverage[0], 0);
}

TEST(SurfaceColour, IsTheSameOnOneThreadAndOnMany) {
  const auto scene = scene_of(kOneBall, small_rig(4), paint);
  const auto many = colours_of(scene);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = colours_of(scene);
  EXPECT_EQ(many.colours, single.colours);
  EXPECT_EQ(many.coverage, single.coverage);
}

TEST(SurfaceColour, ColoursAMirroredWorldLikeTheTrueOne) {
  auto scene = scene_of(kOneBall, small_rig(4), paint);
  const auto truth = colours_of(scene);
  for (auto& view : scene.views) view.camera.R.col(2) *= -1.0;
  for (auto& position : scene.mesh.positions) position.z() *= -1.0F;
  for (auto& normal : scene.mesh.normals) normal.z() *= -1.0F;
  const auto mirrored = colours_of(scene);
  EXPECT_EQ(truth.coverage, mirrored.coverage);
  for (std::size_t i = 0; i < truth.colours.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(truth.colours[i][c], mirrored.colours[i][c], 1);
}

TEST(SurfaceColour, RefusesPicturesThatAreNotOfTheCamerasSize) {
  auto scene = scene_of(kOneBall, small_rig(2), paint);
  scene.views[1].rgb = cv::Mat(10, 10, CV_8UC3);
  EXPECT_THROW(colours_of(scene), InvalidInput);
  EXPECT_THROW(surface_colour(scene.mesh.positions, {}, scene.mesh, {}), InvalidInput);
}

}  // namespace rotunda::recon
