#include "recon/hull/visual_hull.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>

#include "config/errors.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/marching_cubes.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

const Eigen::Vector3d kMiddle(0.1, -0.05, 1.0);
constexpr double kRadius = 0.35;

simulator::LayoutOptions small_rig(int cameras = 10) {
  simulator::LayoutOptions options;
  options.cameras = cameras;
  options.width = 160;
  options.height = 128;
  return options;
}

VisualHullOptions stage() {
  return {.bounds = {Eigen::Vector3d(-1.0, -1.0, 0.0), Eigen::Vector3d(1.0, 1.0, 2.0)}, .cell_size = 0.03};
}

SignedGrid hull_of(const tests::CapsuleBody& body, const std::vector<capture::CameraModel>& cameras,
                   const VisualHullOptions& options) {
  return visual_hull(cameras, tests::mattes_of(body, cameras), options);
}

// Mean and least radius of the hull's surface about the ball's middle.
struct Radii {
  double mean = 0.0, least = 1e9;
};
Radii radii_of(const SignedGrid& grid) {
  Radii radii;
  const auto mesh = marching_cubes(grid);
  for (const auto& p : mesh.positions) {
    const double r = (p.cast<double>() - kMiddle).norm();
    radii.mean += r / static_cast<double>(mesh.positions.size());
    radii.least = std::min(radii.least, r);
  }
  return radii;
}

TEST(VisualHull, HoldsTheBallThatCastTheSilhouettes) {
  const auto cameras = simulator::camera_layout(small_rig());
  const auto grid = hull_of(tests::ball(kMiddle, kRadius), cameras, stage());
  const auto radii = radii_of(grid);
  EXPECT_GE(radii.least,
            kRadius - 0.006);  // a hull never cuts into the body: a third of a pixel (18 mm) is left for noise
  const double truth = 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius, 3);
  const double volume = signed_volume(marching_cubes(grid));
  EXPECT_GT(volume, 0.99 * truth);
  EXPECT_LT(volume, 1.10 * truth);  // ten cones leave about 6 % around a ball
}

TEST(VisualHull, IsTheSameWithSkewOddPixelsAndDistortion) {
  const auto plain = radii_of(hull_of(tests::ball(kMiddle, kRadius), simulator::camera_layout(small_rig()), stage()));
  auto options = small_rig();
  options.aspect = 16.0 / 15.0;
  options.skew_px = 3.0;
  options.k1 = -0.12;
  options.k2 = 0.03;
  const auto odd = radii_of(hull_of(tests::ball(kMiddle, kRadius), simulator::camera_layout(options), stage()));
  EXPECT_NEAR(odd.mean, plain.mean, 0.001);
  EXPECT_NEAR(odd.least, plain.least, 0.003);
}

TEST(VisualHull, AcceptsAMirroredWorld) {
  auto cameras = simulator::camera_layout(small_rig());
  const auto mattes = tests::mattes_of(tests::ball(kMiddle, kRadius), cameras);
  for (auto& camera : cameras) camera.R.col(1) *= -1.0;  // y turned about: det R = -1
  auto options = stage();
  const auto mesh = marching_cubes(visual_hull(cameras, mattes, options));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : mesh.positions) mean += p.cast<double>() / static_cast<double>(mesh.positions.size());
  EXPECT_LT((mean - Eigen::Vector3d(0.1, 0.05, 1.0)).norm(), 0.01);
  EXPECT_GT(signed_volume(mesh), 0.0);
}

TEST(VisualHull, GivesTheSameOnOneThreadAndMany) {
  const auto cameras = simulator::camera_layout(small_rig(6));
  const auto mattes = tests::mattes_of(tests::person(), cameras);
  const auto many = visual_hull(cameras, mattes, stage());
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = visual_hull(cameras, mattes, stage());
  ASSERT_EQ(many.block_count(), single.block_count());
  for (std::size_t b = 0; b < many.block_count(); ++b) {
    EXPECT_EQ(many.block(b), single.block(b));
    EXPECT_EQ(many.values(b), single.values(b));
  }
}

TEST(VisualHull, AgreesWithTheFieldOfAllSamples) {
  const auto cameras = simulator::camera_layout(small_rig(5));
  const auto views = silhouette_views(cameras, tests::mattes_of(tests::person(), cameras));
  const auto grid = visual_hull(views, stage());
  for (int i = 0; i < 9680; ++i) {  // a lattice of the whole volume, blocks the search left out included
    const Eigen::Vector3i c(i % 22 * 3, i / 22 % 22 * 3 + 1, i / 484 * 3 + 1);
    const Eigen::Vector3d p = grid.origin() + grid.cell_size() * c.cast<double>();
    float least = 1e9F;
    int seen = 0;
    for (const auto& view : views)
      if (const auto d = view.distance(p)) least = std::min(least, *d), ++seen;
    if (seen < 2) continue;
    EXPECT_EQ(grid.value(grid.find(c)), std::max(least, grid.outside())) << c.transpose();
  }
}

TEST(VisualHull, OutsideOfAPictureIsUnknownNotEmpty) {
  auto cameras = simulator::camera_layout(small_rig());
  for (std::size_t i = 0; i < 3; ++i) {  // three cameras see only the upper part
    cameras[i].height = 60;
  }
  const auto grid = hull_of(tests::ball(kMiddle, kRadius), cameras, stage());
  EXPECT_GE(radii_of(grid).least, kRadius - 0.006);
}

TEST(VisualHull, OneViewIsNotEnoughToSeeAPoint) {
  auto cameras = simulator::camera_layout(small_rig(2));
  cameras[1] = cameras[0];
  cameras[1].R.row(0) *= -1.0;  // looks the other way
  cameras[1].R.row(2) *= -1.0;
  cameras[1].t = -cameras[1].R * cameras[0].centre();
  std::vector<capture::Matte> mattes(2);
  for (auto& matte : mattes) matte.alpha = cv::Mat(128, 160, CV_8UC1, cv::Scalar(255));
  EXPECT_EQ(visual_hull(cameras, mattes, stage()).block_count(), 0U);
}

TEST(VisualHull, ToleratesAMissInOneView) {
  const auto cameras = simulator::camera_layout(small_rig());
  auto mattes = tests::mattes_of(tests::ball(kMiddle, kRadius), cameras);
  mattes[4].alpha.setTo(0);
  auto options = stage();
  EXPECT_TRUE(marching_cubes(visual_hull(cameras, mattes, options)).triangles.empty());
  options.tolerate_misses = 1;
  EXPECT_GE(radii_of(visual_hull(cameras, mattes, options)).least, kRadius - 0.006);
}

TEST(VisualHull, RefusesWhatCannotBeCarved) {
  const auto cameras = simulator::camera_layout(small_rig(3));
  const auto mattes = tests::mattes_of(tests::ball(kMiddle, kRadius), cameras);
  EXPECT_THROW(visual_hull(std::span(cameras).first(2), mattes, stage()), InvalidInput);
  EXPECT_THROW(visual_hull(std::span(cameras).first(1), std::span(mattes).first(1), stage()), InvalidInput);
  EXPECT_THROW(visual_hull(cameras, mattes, VisualHullOptions{}), InvalidInput);
  auto options = stage();
  options.cell_size = 1e-7;
  EXPECT_THROW(visual_hull(cameras, mattes, options), InvalidInput);
  auto wrong = mattes;
  wrong[1].alpha = cv::Mat::zeros(10, 10, CV_8UC1);
  try {
    visual_hull(cameras, wrong, stage());
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("cam01"), std::string::npos);
  }
}

TEST(CaptureVolume, IsFoundAtAnyScaleAndHoldsTheBody) {
  const auto mattes = tests::mattes_of(tests::person(), simulator::camera_layout(small_rig()));
  for (const double scale : {1.0, 0.02, 300.0}) {
    auto cameras = simulator::camera_layout(small_rig());
    for (auto& camera : cameras) camera.t *= scale;
    const auto box = capture_volume(silhouette_views(cameras, mattes));
    EXPECT_TRUE(box.contains(scale * Eigen::Vector3d(0, 0, 1.77))) << scale;     // top of the head
    EXPECT_TRUE(box.contains(scale * Eigen::Vector3d(0, 0.15, 0.01))) << scale;  // a sole
    EXPECT_TRUE(box.contains(scale * Eigen::Vector3d(0.1, -0.63, 1.0))) << scale;
    EXPECT_LT(box.sizes().maxCoeff(), scale * 2.6) << scale;
  }
}

TEST(CaptureVolume, NamesTheCamerasWithoutASilhouette) {
  const auto cameras = simulator::camera_layout(small_rig(4));
  auto mattes = tests::mattes_of(tests::person(), cameras);
  for (auto& matte : mattes) matte.alpha.setTo(0);
  try {
    capture_volume(silhouette_views(cameras, mattes));
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("cam00, cam01, cam02, cam03"), std::string::npos) << error.what();
  }
}

TEST(CaptureVolume, CellsAreTenMillimetresOnlyWhereMetresArePlausible) {
  const Eigen::AlignedBox3d stage_box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 2, 1));
  EXPECT_DOUBLE_EQ(default_cell_size(stage_box, "m"), 0.010);
  EXPECT_DOUBLE_EQ(default_cell_size(stage_box, ""), 3.0 / 200.0);
  const Eigen::AlignedBox3d toy(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.02, 0.02, 0.01));
  EXPECT_DOUBLE_EQ(default_cell_size(toy, "m"), 0.03 / 200.0);
}

}  // namespace
}  // namespace rotunda::recon
