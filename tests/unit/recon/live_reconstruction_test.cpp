#include "recon/live_reconstruction.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "recon/hull/surface.h"
#include "recon/live/live_paint.h"
#include "recon/mesh/triangle_mesh.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"

namespace rotunda::recon {
namespace {

constexpr int kWidth = 240, kHeight = 192;
constexpr double kRadius = 0.45;
const cv::Vec3f kBlue(40, 60, 190);
const cv::Vec3b kAbove(200, 60, 50), kBelow(210, 190, 60);
const tests::Ball kBall{{0.1, 0.0, 1.0}, kRadius};

cv::Vec3f two_colours(std::size_t, const Eigen::Vector3d& point) {
  return point.z() > kBall.centre.z() ? kAbove : kBelow;
}

capture::Image image_of(const cv::Mat& rgb) {
  return capture::make_image(rgb.cols, rgb.rows, capture::PixelFormat::rgb8, {rgb.datastart, rgb.dataend});
}

struct Scene {
  StudioViews studio;
  capture::FrameSet set;
};

Scene scene_of(std::span<const tests::Ball> balls) {
  Scene scene;
  scene.studio.cameras = simulator::camera_layout({.cameras = 8, .width = kWidth, .height = kHeight});
  const cv::Mat plate(kHeight, kWidth, CV_8UC3, cv::Scalar(kBlue[0], kBlue[1], kBlue[2]));
  for (const auto& camera : scene.studio.cameras) {
    scene.studio.backgrounds.push_back(plate);
    scene.studio.live_keys.emplace_back(std::in_place, plate, capture::PixelFormat::rgb8);
    capture::Frame frame;
    frame.camera = camera.name;
    frame.image = image_of(tests::picture_of(camera, balls, kBlue, two_colours).rgb);
    scene.set.slots.push_back({std::move(frame), std::nullopt});
  }
  return scene;
}

const LiveOptions kOptions{.bounds = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(1, 1, 2)),
                           .cell_size = 0.03};

TEST(LiveReconstruction, MakesOneClosedSurfaceInThePerformersColours) {
  const auto scene = scene_of({{kBall}});
  StageClock clock;
  const auto frame = reconstruct_live(scene.set, scene.studio, kOptions, clock);
  ASSERT_EQ(frame.failure, "");
  EXPECT_TRUE(topology_of(frame.mesh).is_sphere());
  const double truth = 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius, 3);
  EXPECT_NEAR(signed_volume(frame.mesh), truth, 0.1 * truth);  // eight cones: + 3 %; half a pixel of 8 mm: 5 %
  ASSERT_EQ(frame.mesh.colours.size(), frame.mesh.positions.size());
  std::size_t clear = 0, right = 0;
  for (std::size_t v = 0; v < frame.mesh.positions.size(); ++v) {
    const double up = frame.mesh.positions[v].z() - kBall.centre.z();
    if (std::abs(up) < 0.06) continue;  // both colours are near
    ++clear;
    const auto& truth_there = up > 0.0 ? kAbove : kBelow;
    right += std::abs(frame.mesh.colours[v][0] - truth_there[0]) < 25 &&
             std::abs(frame.mesh.colours[v][1] - truth_there[1]) < 25 &&
             std::abs(frame.mesh.colours[v][2] - truth_there[2]) < 25;
  }
  EXPECT_GT(right, clear * 97 / 100) << "no blue of the screen, and what no camera sees is filled";
}

Eigen::Vector3d middle_of(const TriangleMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& position : mesh.positions) sum += position.cast<double>();
  return sum / static_cast<double>(mesh.positions.size());
}

// Cells of 100 mm need no more than silhouettes of a quarter of the size; half a pixel's mistake there would be 16 mm.
TEST(LiveReconstruction, IsWhereTheOfflineSurfaceIsAlsoWithReducedSilhouettes) {
  const auto scene = scene_of({{kBall}});
  auto options = kOptions;
  options.cell_size = 0.1;
  StageClock clock;
  const auto live = reconstruct_live(scene.set, scene.studio, options, clock);
  ASSERT_EQ(live.failure, "");
  auto unreduced = live_surface({.bounds = options.bounds, .cell_size = 0.1});
  unreduced.coarseness = 1.0;
  const auto views = key_frame(scene.set, scene.studio, {}, clock);
  const auto offline = reconstruct_surface(views.cameras, views.mattes, unreduced);
  EXPECT_LT((middle_of(live.mesh) - middle_of(offline.mesh)).norm(), 0.006);
  // A tenth of a reduced pixel, half a cell wide, all around.
  const double volume = signed_volume(offline.mesh), radius = std::cbrt(volume * 3.0 / (4.0 * std::numbers::pi));
  EXPECT_NEAR(signed_volume(live.mesh), volume, 3.0 * 0.1 * 0.05 / radius * volume);
}

// Both balls are seen by all cameras, one before the other by some: what is hidden takes its colour from other views.
TEST(LiveReconstruction, NoSurfaceTakesTheColourOfWhatHidesIt) {
  auto mesh = TriangleMesh{};
  const tests::Ball near{{0.0, -0.5, 1.0}, 0.2}, far{{0.0, 0.5, 1.0}, 0.2};
  append_ball(near, 16, mesh);
  const auto first_of_far = mesh.positions.size();
  append_ball(far, 16, mesh);
  const std::array<tests::Ball, 2> balls{near, far};
  const auto cameras = simulator::camera_layout({.cameras = 8, .width = kWidth, .height = kHeight});
  std::vector<capture::HalfMatte> mattes;
  std::vector<LiveSilhouette> silhouettes;
  for (const auto& camera : cameras) {
    const auto picture = tests::picture_of(camera, balls, kBlue, [](std::size_t ball, const Eigen::Vector3d&) {
      return ball == 0 ? cv::Vec3f(kAbove) : cv::Vec3f(kBelow);
    });
    cv::Mat alpha;
    cv::resize(picture.alpha, alpha, {kWidth / 2, kHeight / 2}, 0, 0, cv::INTER_AREA);
    const cv::Rect whole({}, alpha.size());
    mattes.push_back({alpha, whole, capture::half_picture(picture.rgb, capture::PixelFormat::rgb8)});
    silhouettes.emplace_back(reduced_camera(camera, 2), alpha, whole, 1);
  }
  std::vector<PaintView> views;
  for (std::size_t i = 0; i < cameras.size(); ++i) views.push_back({.view = &silhouettes[i], .matte = &mattes[i]});
  paint_live(mesh, views, capture::Backdrop::blue);
  std::size_t wrong = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (mesh.normals[v].z() < -0.5F) continue;  // the cameras stand above: along the outline at best
    const int truth = v < first_of_far ? kAbove[1] : kBelow[1];
    wrong += std::abs(mesh.colours[v][1] - truth) > 30;
  }
  EXPECT_LT(wrong, mesh.positions.size() / 100);
}

TEST(LiveReconstruction, IsTheSameOnOneThreadAndOnMany) {
  const auto scene = scene_of({{kBall}});
  StageClock clock;
  const auto many = reconstruct_live(scene.set, scene.studio, kOptions, clock);
  tbb::task_arena alone(1);
  const auto one = alone.execute([&] { return reconstruct_live(scene.set, scene.studio, kOptions, clock); });
  EXPECT_EQ(one.mesh.positions, many.mesh.positions);
  EXPECT_EQ(one.mesh.triangles, many.mesh.triangles);
  EXPECT_EQ(one.mesh.colours, many.mesh.colours);
}

TEST(LiveReconstruction, SaysWhyThereIsNoSurface) {
  StageClock clock;
  const auto empty = scene_of({});
  EXPECT_NE(reconstruct_live(empty.set, empty.studio, kOptions, clock).failure, "");
  auto scene = scene_of({{kBall}});
  for (std::size_t i = 1; i < scene.set.slots.size(); ++i)
    scene.set.slots[i] = {std::nullopt, capture::HoleReason::camera_lost};
  EXPECT_EQ(reconstruct_live(scene.set, scene.studio, kOptions, clock).failure,
            "fewer than two cameras have a picture");
}

}  // namespace
}  // namespace rotunda::recon
