#include "recon/hull/genus_cut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "recon/hull/marching_cubes.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

using Field = std::function<double(const Eigen::Vector3d&)>;

SignedGrid grid_of(const Field& field, int blocks, double cell) {
  std::vector<Eigen::Vector3i> all;
  for (int z = 0; z < blocks; ++z)
    for (int y = 0; y < blocks; ++y)
      for (int x = 0; x < blocks; ++x) all.emplace_back(x, y, z);
  const double half = 0.5 * blocks * SignedGrid::kSide * cell;
  SignedGrid grid(Eigen::Vector3d::Constant(-half), cell, static_cast<float>(-3.0 * cell), all);
  for (VoxelId id = 0; id < grid.voxel_count(); ++id) grid.set_value(id, static_cast<float>(field(grid.position(id))));
  return grid;
}

Field body_field(const tests::CapsuleBody& body) {
  return [body](const Eigen::Vector3d& p) { return tests::signed_distance(body, p); };
}

SignedGrid noise(unsigned seed, double threshold) {
  std::mt19937 random(seed);
  std::normal_distribution<double> value(0.0, 1.0);
  return grid_of([&](const Eigen::Vector3d&) { return value(random) - threshold; }, 2, 0.01);
}

TEST(MarchingCubes, IsClosedAndManifoldAtTheEdgesOfAnyRandomField) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const auto mesh = marching_cubes(noise(seed, 0.25 * seed - 1.0));
    EXPECT_TRUE(topology_of(mesh).closed) << seed;
  }
}

TEST(MarchingCubes, EveryCubeHasTheEulerCharacteristicOfTwentySixConnectedInsides) {
  // chi of a surface is twice that of the solid; the solid's is counted on its 26-clique complex: an inside sample each
  // cell, face and edge of the grid that has one, alternately signed (each meets the solid in one ball).
  for (unsigned seed = 0; seed < 8; ++seed) {
    const auto grid = noise(100 + seed, 0.8);
    const auto inside = [&](const Eigen::Vector3i& c) {
      const auto id = grid.find(c);
      return id != kNoVoxel && grid.value(id) > 0.0F;
    };
    long chi = 0;
    for (int z = -1; z < 16; ++z)
      for (int y = -1; y < 16; ++y)
        for (int x = -1; x < 16; ++x)
          for (int extent = 0; extent < 8; ++extent) {  // the lattice cell at x, y, z that spans these axes
            bool any = false;
            for (int corner = 0; corner < 8; ++corner)
              if ((corner & ~extent) == 0)
                any = any || inside({x + (corner & 1), y + ((corner >> 1) & 1), z + (corner >> 2)});
            const int dimension = (extent & 1) + ((extent >> 1) & 1) + (extent >> 2);
            if (any) chi += (3 - dimension) % 2 == 0 ? 1 : -1;  // dual cell: its dimension is 3 minus this one's
          }
    EXPECT_EQ(topology_of(marching_cubes(grid)).euler_characteristic, 2 * chi) << seed;
  }
}

TEST(MarchingCubes, PutsABallsSurfaceBetweenTheSamples) {
  const auto mesh = marching_cubes(grid_of(body_field(tests::ball({0.003, -0.002, 0.001}, 0.1)), 4, 0.01));
  const auto topology = topology_of(mesh);
  EXPECT_TRUE(topology.is_sphere());
  for (const auto& p : mesh.positions)
    EXPECT_NEAR((p.cast<double>() - Eigen::Vector3d(0.003, -0.002, 0.001)).norm(), 0.1,
                2e-4);  // chord of a cell: 1 mm^2 / 8 r
  EXPECT_NEAR(signed_volume(mesh), 4.0 / 3.0 * std::numbers::pi * 1e-3, 0.01 * 4.19e-3);  // and it faces outwards
}

TEST(MarchingCubes, ClosesTheSurfaceWhereTheGridEnds) {
  const auto mesh = marching_cubes(grid_of([](const Eigen::Vector3d&) { return 0.01; }, 1, 0.01));
  EXPECT_TRUE(topology_of(mesh).is_sphere());
}

TEST(GenusCut, LeavesABallAsItIs) {
  auto grid = grid_of(body_field(tests::ball({0, 0, 0}, 0.1)), 4, 0.01);
  const auto before = marching_cubes(grid);
  const auto report = cut_to_genus_zero(grid);
  EXPECT_EQ(report.pieces.pieces, 1U);
  EXPECT_EQ(report.cut_voxels + report.filled_voxels + report.pieces.dropped_voxels, 0U);
  EXPECT_EQ(marching_cubes(grid).positions, before.positions);
}

TEST(GenusCut, CutsARingWithLittleLoss) {
  auto grid = grid_of(body_field(tests::ring({0, 0, 0}, {1, 0, 0}, {0, 0.8, 0.6}, 0.09, 0.025)), 4, 0.01);
  EXPECT_EQ(topology_of(marching_cubes(grid)).euler_characteristic, 0);
  const auto report = cut_to_genus_zero(grid);
  EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere());
  EXPECT_GT(report.cut_voxels, 0U);
  EXPECT_LT(report.cut_voxels, 80U);  // one sample deep across a neck of 2.5 cells' radius: about 20, aslant more
}

TEST(GenusCut, KeepsTheLargestOfTwoLinkedRings) {
  auto body = tests::ring({-0.04, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.08, 0.02);
  const auto other = tests::ring({0.05, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.08, 0.016);
  body.insert(body.end(), other.begin(), other.end());
  auto grid = grid_of(body_field(body), 5, 0.01);
  const auto report = cut_to_genus_zero(grid);
  EXPECT_EQ(report.pieces.pieces, 2U);
  EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere());
}

TEST(GenusCut, FillsCavities) {
  auto grid = grid_of([](const Eigen::Vector3d& p) { return 0.03 - std::abs(p.norm() - 0.09); }, 4, 0.01);
  const auto report = cut_to_genus_zero(grid);
  EXPECT_GT(report.filled_voxels, 100U);
  EXPECT_EQ(report.cut_voxels, 0U);
  EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere());
}

TEST(GenusCut, CutsWhereTouchingLimbsMeet) {
  // An arm of 4.5 cells' radius whose hand just touches a trunk: the loop must open at the hand, not in the arm.
  const tests::CapsuleBody body{{{0, 0, -0.15}, {0, 0, 0.15}, 0.06},
                                {{0, 0.03, 0.13}, {0, 0.16, 0.05}, 0.045},
                                {{0, 0.16, 0.05}, {0, 0.098, -0.08}, 0.045}};
  auto grid = grid_of(body_field(body), 6, 0.01);
  ASSERT_EQ(topology_of(marching_cubes(grid)).euler_characteristic, 0);
  const auto whole = grid;
  cut_to_genus_zero(grid);
  EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere());
  for (VoxelId id = 0; id < grid.voxel_count(); ++id) {
    if (grid.value(id) == whole.value(id)) continue;
    EXPECT_LT(grid.position(id).z(), 0.0);
    EXPECT_LT(grid.position(id).y(), 0.09);
  }
}

TEST(GenusCut, MakesASphereOfEveryRandomBlob) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-0.09, 0.09), radius(0.01, 0.04);
    tests::CapsuleBody body;
    for (int i = 0; i < 12; ++i) {
      const auto point = [&] { return Eigen::Vector3d(place(random), place(random), place(random)); };
      const auto a = point(), b = point();
      body.push_back({a, b, radius(random)});
    }
    auto grid = grid_of(body_field(body), 4, 0.01);
    cut_to_genus_zero(grid);
    EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere()) << seed;
  }
}

TEST(GenusCut, MakesASphereOfPureNoise) {
  for (unsigned seed = 0; seed < 16; ++seed) {
    auto grid = noise(seed, 0.12 * seed - 0.9);
    if (cut_to_genus_zero(grid).solid_voxels == 0) continue;
    EXPECT_TRUE(topology_of(marching_cubes(grid)).is_sphere()) << seed;
  }
}

TEST(GenusCut, LeavesAnEmptyGridEmpty) {
  auto grid = grid_of([](const Eigen::Vector3d&) { return -1.0; }, 1, 0.01);
  EXPECT_EQ(cut_to_genus_zero(grid).solid_voxels, 0U);
  EXPECT_TRUE(marching_cubes(grid).triangles.empty());
}

}  // namespace
}  // namespace rotunda::recon
