#include "recon/hull/solid_pieces.h"

#include <gtest/gtest.h>

#include "recon/hull/marching_cubes.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

constexpr double kCell = 0.01;

// Of three balls at x = -0.3, 0, 0.4 with radii of 5, 4 and 3 cells, and only the blocks about them.
SignedGrid three_balls() {
  tests::CapsuleBody body;
  for (const auto& [x, radius] : {std::pair{-0.3, 0.05}, {0.0, 0.04}, {0.4, 0.03}})
    body.push_back(tests::ball({x, 0.0, 0.0}, radius).front());
  std::vector<Eigen::Vector3i> blocks;
  const double block = kCell * SignedGrid::kSide;
  for (int x = -6; x < 8; ++x)
    for (int y = -1; y < 1; ++y)
      for (int z = -1; z < 1; ++z)
        if (tests::signed_distance(body, block * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5))) > -block)
          blocks.emplace_back(x, y, z);
  SignedGrid grid(Eigen::Vector3d::Zero(), kCell, -0.03F, blocks);
  for (VoxelId id = 0; id < grid.voxel_count(); ++id)
    grid.set_value(id, static_cast<float>(std::max(-0.03, tests::signed_distance(body, grid.position(id)))));
  return grid;
}

bool is_inside(const SignedGrid& grid, double x) {
  return grid.sample({x, 0.0, 0.0}) > 0.0F;
}

TEST(SolidPieces, KeepTheLargest) {
  auto grid = three_balls();
  const auto report = settle_pieces(grid);
  EXPECT_EQ(report.pieces, 3U);
  EXPECT_TRUE(is_inside(grid, -0.3));
  EXPECT_FALSE(is_inside(grid, 0.0) || is_inside(grid, 0.4));
  EXPECT_EQ(topology_of(marching_cubes(grid)).components, 1U);
}

TEST(SolidPieces, KeepWhoeverStandsAtThePlaceAskedFor) {
  auto grid = three_balls();
  settle_pieces(grid, {.performer_at = Eigen::Vector2d(0.35, 0.2)});
  EXPECT_TRUE(is_inside(grid, 0.4));
  EXPECT_FALSE(is_inside(grid, 0.0) || is_inside(grid, -0.3));
}

TEST(SolidPieces, NeverKeepASpeckForAPerson) {
  auto grid = three_balls();
  grid.set_value(grid.find({39, 5, 0}), 0.001F);  // beside the smallest ball
  settle_pieces(grid, {.performer_at = Eigen::Vector2d(0.39, 0.06)});
  EXPECT_TRUE(is_inside(grid, 0.4));
}

TEST(SolidPieces, AreTiedAcrossWhatTheGridDoesNotStore) {
  auto grid = three_balls();
  ASSERT_EQ(grid.find({-15, 0, 0}), kNoVoxel) << "between the balls";
  const auto report = settle_pieces(grid, {.tied_volume = 2e-4});  // the middle ball has 2.7e-4, the smallest 1.1e-4
  EXPECT_EQ(report.tied, 1U);
  EXPECT_TRUE(is_inside(grid, -0.3) && is_inside(grid, -0.15) && is_inside(grid, 0.0));
  EXPECT_FALSE(is_inside(grid, 0.4));
  const auto mesh = marching_cubes(grid);
  EXPECT_TRUE(topology_of(mesh).is_sphere());
  EXPECT_NEAR(signed_volume(mesh), 4.0 / 3.0 * std::numbers::pi * (1.25e-4 + 0.64e-4), 0.1 * 7.9e-4);
  for (const auto& p : mesh.positions)
    EXPECT_TRUE(p.x() < -0.24F || p.x() > -0.05F || p.tail<2>().norm() < 0.012F) << "thin";
}

TEST(SolidPieces, AllTiedAreOne) {
  auto grid = three_balls();
  EXPECT_EQ(settle_pieces(grid, {.tied_volume = 1e-9}).tied, 2U);
  EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere());
  EXPECT_EQ(settle_pieces(grid).pieces, 1U);
}

TEST(SolidPieces, OfNothingAreNone) {
  SignedGrid grid(Eigen::Vector3d::Zero(), kCell, -0.03F, {{0, 0, 0}});
  EXPECT_EQ(settle_pieces(grid, {.performer_at = Eigen::Vector2d(0, 0), .tied_volume = 1.0}).pieces, 0U);
}

}  // namespace
}  // namespace rotunda::recon
