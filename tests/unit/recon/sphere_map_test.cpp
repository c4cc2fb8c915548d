#include "recon/sphere/sphere_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "tests/support/closed_shapes.h"

namespace rotunda::recon {
namespace {

using testing::HasSubstr;

TEST(SphereMap, IsOneToOneAndEvenOnABodyWithThinLimbs) {
  const auto mesh = tests::starfish(4);
  const auto [map, report] = map_to_sphere(mesh);
  ASSERT_TRUE(map) << report.failure;
  EXPECT_EQ(flipped_triangles(mesh, *map), 0U);
  EXPECT_LE(report.area_error, 1e-9);
  EXPECT_EQ(report.splits, mesh.positions.size() - 4);
  for (const auto& point : map->points) ASSERT_NEAR(point.norm(), 1.0, 1e-14);
  EXPECT_GE(report.spread.min, 0.05);
  EXPECT_LE(report.spread.p95 / report.spread.p5, 6.0);
}

TEST(SphereMap, OfASphereIsNearlyTheSphereItself) {
  const auto mesh = tests::icosphere(3);
  const auto map = map_to_sphere(mesh).map;
  ASSERT_TRUE(map);
  double worst = 0.0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    worst = std::max(worst, (map->points[v] - mesh.positions[v].cast<double>()).norm());
  EXPECT_LT(worst, 0.1);  // within an edge (0.15): even density and shape leave little else
}

TEST(SphereMap, IsTheSameEveryTime) {
  const auto mesh = tests::starfish(2);
  EXPECT_EQ(map_to_sphere(mesh).map->points, map_to_sphere(mesh).map->points);
}

TEST(SphereMap, OfATetrahedronNeedsNoSplit) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const auto [map, report] = map_to_sphere(mesh);
  ASSERT_TRUE(map) << report.failure;
  EXPECT_NEAR(report.spread.min, 1.0, 1e-9);
}

TEST(SphereMap, LeavesOutVerticesWithoutTriangles) {
  auto mesh = tests::icosphere(1);
  mesh.positions.insert(mesh.positions.begin(), Eigen::Vector3f(9, 9, 9));
  for (auto& t : mesh.triangles)
    for (auto& v : t) ++v;
  const auto [map, report] = map_to_sphere(mesh);
  ASSERT_TRUE(map) << report.failure;
  EXPECT_EQ(map->points.size(), mesh.positions.size());
}

TEST(SphereMap, SurvivesTrianglesWithoutArea) {
  auto mesh = tests::icosphere(2);
  for (const auto v : mesh.triangles[7]) mesh.positions[v] = mesh.positions[mesh.triangles[7][0]];
  const auto [map, report] = map_to_sphere(mesh);
  ASSERT_TRUE(map) << report.failure;
  EXPECT_EQ(flipped_triangles(mesh, *map), 0U);
}

TEST(SphereMap, TellsWhyAMeshHasNone) {
  EXPECT_THAT(map_to_sphere({}).report.failure, HasSubstr("no triangles"));
  EXPECT_THAT(map_to_sphere(tests::torus()).report.failure, HasSubstr("1 handle"));

  auto open = tests::icosphere(2);
  open.triangles.pop_back();
  EXPECT_THAT(map_to_sphere(open).report.failure, HasSubstr("not closed"));

  auto two = tests::icosphere(1);
  const auto count = static_cast<std::uint32_t>(two.positions.size());
  for (std::size_t t = 0, end = two.triangles.size(); t < end; ++t) {
    const auto triangle = two.triangles[t];
    two.triangles.push_back({triangle[0] + count, triangle[1] + count, triangle[2] + count});
  }
  two.positions.insert(two.positions.end(), two.positions.begin(), two.positions.begin() + count);
  EXPECT_THAT(map_to_sphere(two).report.failure, HasSubstr("2 separate surfaces"));

  auto joined = two;  // the two spheres share one vertex
  for (auto& t : joined.triangles)
    for (auto& v : t)
      if (v == count) v = 0;
  EXPECT_THAT(map_to_sphere(joined).report.failure, HasSubstr("not manifold"));

  auto wild = tests::icosphere(1);
  wild.triangles[3][1] = 4000;
  EXPECT_THAT(map_to_sphere(wild).report.failure, HasSubstr("triangle 3 names vertex 4000"));

  auto endless = tests::icosphere(1);
  endless.positions[5].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(map_to_sphere(endless).report.failure, HasSubstr("vertex 5"));
}

TEST(SphereMapAlignment, TurnsDirectionsTowardsNormals) {
  const auto mesh = tests::icosphere(2);
  SphereMap spun;
  const auto turn = Eigen::AngleAxisd(1.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const auto& p : mesh.positions) spun.points.push_back(turn * p.cast<double>());
  const auto aligned = align_to_normals(mesh, spun);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_LT((aligned.points[v] - mesh.positions[v].cast<double>()).norm(), 1e-5);
}

TEST(SphereMapAlignment, KeepsASequenceFromSpinning) {
  const auto mesh = tests::starfish(2);
  const auto map = map_to_sphere(mesh).map.value();
  auto moved = mesh;
  for (auto& p : moved.positions) p += Eigen::Vector3f(0.01F, 0.0F, 0.0F);
  SphereMap spun;
  const auto turn = Eigen::AngleAxisd(2.0, Eigen::Vector3d(0, 1, 1).normalized()).toRotationMatrix();
  for (const auto& p : map.points) spun.points.push_back(turn * p);
  const auto aligned = align_to(moved, spun, mesh, map);
  for (std::size_t v = 0; v < map.points.size(); ++v) EXPECT_LT((aligned.points[v] - map.points[v]).norm(), 0.1);
}

}  // namespace
}  // namespace rotunda::recon
