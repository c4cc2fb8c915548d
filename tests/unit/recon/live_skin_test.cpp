#include "recon/live/live_skin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "recon/hull/genus_cut.h"
#include "recon/hull/marching_cubes.h"

namespace rotunda::recon {
namespace {

constexpr double kCell = 0.02;

// A field over a cube of 64^3 samples about the origin.
SignedGrid grid_of(const std::function<double(const Eigen::Vector3d&)>& field) {
  std::vector<Eigen::Vector3i> blocks;
  for (int i = 0; i < 512; ++i) blocks.emplace_back(i & 7, (i >> 3) & 7, i >> 6);
  SignedGrid grid(Eigen::Vector3d::Constant(-32.0 * kCell), kCell, static_cast<float>(-3.0 * kCell), blocks);
  for (VoxelId id = 0; id < grid.voxel_count(); ++id) grid.set_value(id, static_cast<float>(field(grid.position(id))));
  return grid;
}

double ring(const Eigen::Vector3d& p) {
  return 0.1 - std::hypot(std::hypot(p.x(), p.y()) - 0.4, p.z());
}

TEST(LiveSkin, CutsAHandleAndFillsACavity) {
  auto grid = grid_of([](const Eigen::Vector3d& p) {
    const double hollow = (p - Eigen::Vector3d(0.4, 0, 0)).norm() - 0.05;
    return std::min(ring(p), hollow);
  });
  ASSERT_EQ(topology_of(marching_cubes(grid)).components, 2U) << "a ring with a bubble in it";
  const auto mesh = live_skin(grid, 0.15);
  EXPECT_TRUE(topology_of(mesh).is_sphere());
  EXPECT_GT(signed_volume(mesh), 0.9 * 2.0 * M_PI * M_PI * 0.4 * 0.1 * 0.1) << "a slice is cut out, no more";
}

TEST(LiveSkin, KeepsTheLargestPieceAlone) {
  auto grid = grid_of([](const Eigen::Vector3d& p) {
    return std::max(0.25 - (p - Eigen::Vector3d(-0.3, 0, 0)).norm(), 0.15 - (p - Eigen::Vector3d(0.35, 0, 0)).norm());
  });
  const auto mesh = live_skin(grid, 0.15);
  EXPECT_TRUE(topology_of(mesh).is_sphere());
  for (const auto& position : mesh.positions) EXPECT_LT(position.x(), 0.0F);
}

TEST(LiveSkin, KeepsAsMuchAsTheOfflineCut) {
  const auto chain = [](const Eigen::Vector3d& p) {
    return std::max(ring(p - Eigen::Vector3d(0.1, 0, 0)), 0.12 - (p - Eigen::Vector3d(-0.4, 0.1, 0.1)).norm());
  };
  auto live = grid_of(chain), offline = grid_of(chain);
  const auto kept = live_cut(live);
  const auto report = cut_to_genus_zero(offline);
  EXPECT_GT(report.cut_voxels, 0U);
  EXPECT_NEAR(static_cast<double>(kept), static_cast<double>(report.solid_voxels),
              0.01 * static_cast<double>(report.solid_voxels));
}

TEST(LiveSkin, IsEmptyOfAnEmptyGrid) {
  auto grid = grid_of([](const Eigen::Vector3d&) { return -1.0; });
  EXPECT_TRUE(live_skin(grid, 0.15).triangles.empty());
}

}  // namespace
}  // namespace rotunda::recon
