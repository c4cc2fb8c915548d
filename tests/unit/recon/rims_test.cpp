#include "recon/hull/rims.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "recon/hull/genus_cut.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/rim_fit.h"
#include "recon/hull/visual_hull.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

const Eigen::AlignedBox3d kStage{Eigen::Vector3d(-1.5, -1.0, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0)};

std::vector<capture::CameraModel> small_rig(double k1 = 0.0) {
  return simulator::camera_layout({.width = 240, .height = 192, .k1 = k1});
}

TEST(Rims, OfABallLieOnItAndFaceOutwards) {
  const Eigen::Vector3d centre(0.1, -0.05, 1.0);
  const auto body = tests::ball(centre, 0.3);
  for (const double k1 : {0.0, -0.1}) {
    const auto cameras = small_rig(k1);
    const auto views = silhouette_views(cameras, tests::mattes_of(body, cameras));
    const auto rims = find_rims(views, {.bounds = kStage, .longest = 0.3});
    ASSERT_GT(rims.size(), 1000U);
    double sum = 0.0;
    for (const auto& rim : rims) {
      sum += std::abs(tests::signed_distance(body, rim.point.cast<double>()));
      const Eigen::Vector3d outward = (rim.point.cast<double>() - centre).normalized();
      ASSERT_GT(outward.dot(rim.normal.cast<double>()), 0.8);
    }
    EXPECT_LT(sum / static_cast<double>(rims.size()), 0.006);  // half a pixel of 12 mm
  }
}

TEST(Rims, AreAsManyOnAnyStrideAsThereAreOutlinePointsLeft) {
  const auto cameras = small_rig();
  const auto views = silhouette_views(cameras, tests::mattes_of(tests::ball({0, 0, 1}, 0.3), cameras));
  const auto all = find_rims(views, {.bounds = kStage, .longest = 0.3});
  const auto third = find_rims(views, {.bounds = kStage, .longest = 0.3, .stride = 3});
  EXPECT_NEAR(static_cast<double>(third.size()), static_cast<double>(all.size()) / 3.0, 0.1 * double(all.size()));
}

TEST(Rims, AreNoneWhereRaysLeaveSeveralStretches) {
  // Seen from the side the two balls are one behind the other: a view between them alone cannot tell.
  const auto cameras = small_rig();
  tests::CapsuleBody body = tests::ball({0, 0, 1}, 0.2);
  const auto alone = silhouette_views(cameras, tests::mattes_of(body, cameras));
  const RimOptions options{.bounds = kStage, .longest = 0.3};
  for (const auto& rim : find_rims(alone, options)) ASSERT_LT(rim.length, 0.3F);
  EXPECT_TRUE(find_rims(alone, {.bounds = Eigen::AlignedBox3d(Eigen::Vector3d(1, 0.5, 0), Eigen::Vector3d(1.5, 1, 2)),
                                .longest = 0.3})
                  .empty());
}

double mean_distance(const TriangleMesh& mesh, const tests::CapsuleBody& body) {
  double sum = 0.0;
  for (const auto& p : mesh.positions) sum += std::abs(tests::signed_distance(body, p.cast<double>()));
  return sum / static_cast<double>(mesh.positions.size());
}

TEST(RimFit, BringsTheHullNearerToTheBodyAndNeverOutOfItself) {
  const auto cameras = small_rig();
  const auto body = tests::person();
  const auto views = silhouette_views(cameras, tests::mattes_of(body, cameras));
  auto grid = visual_hull(views, {.bounds = kStage, .cell_size = 0.02});
  cut_to_genus_zero(grid);
  auto mesh = marching_cubes(grid);
  compute_normals(mesh);
  const auto hull = mesh;
  fit_to_rims(mesh, find_rims(views, {.bounds = kStage}), {.cell_size = 0.02});
  EXPECT_LT(mean_distance(mesh, body), 0.85 * mean_distance(hull, body));
  EXPECT_EQ(mesh.triangles, hull.triangles);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    ASSERT_LE((mesh.positions[v] - hull.positions[v]).dot(hull.normals[v]), 1e-6F);
}

}  // namespace
}  // namespace rotunda::recon
