#include "recon/sphere/octahedral_lattice.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "config/errors.h"
#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

std::size_t at(int level, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(lattice_side(level)) + static_cast<std::size_t>(x);
}

TEST(OctahedralLattice, BorderSamplesAreTheSamePointsAsTheirMirrors) {
  for (int level = 1; level <= 5; ++level) {
    const int last = 1 << level;
    const auto directions = lattice_directions(level);
    for (int i = 0; i <= last; ++i) {
      EXPECT_EQ(directions[at(level, i, 0)], directions[at(level, last - i, 0)]);
      EXPECT_EQ(directions[at(level, i, last)], directions[at(level, last - i, last)]);
      EXPECT_EQ(directions[at(level, 0, i)], directions[at(level, 0, last - i)]);
      EXPECT_EQ(directions[at(level, last, i)], directions[at(level, last, last - i)]);
    }
  }
}

TEST(OctahedralLattice, WeldedIsAClosedSphereFacingOutwards) {
  for (int level = 1; level <= 6; ++level) {
    const auto directions = lattice_directions(level);
    const auto lattice = weld_lattice(level);
    TriangleMesh mesh;
    for (const auto sample : lattice.sample_of_vertex) mesh.positions.push_back(directions[sample].cast<float>());
    mesh.triangles = lattice.triangles;
    EXPECT_EQ(mesh.positions.size(), (1U << (2 * level)) + 2U);
    EXPECT_TRUE(topology_of(mesh).is_sphere()) << "level " << level;
    EXPECT_GT(signed_volume(mesh), 0.0);
    double area = 0.0;
    for (const auto& t : lattice_triangles(level)) {
      ASSERT_EQ(orientation(directions[t[0]], directions[t[1]], directions[t[2]]), 1);
      area += spherical_area(directions[t[0]], directions[t[1]], directions[t[2]]);
    }
    EXPECT_NEAR(area, 4.0 * std::numbers::pi, 1e-10);
  }
}

TEST(OctahedralLattice, SamplesTheSphereEvenly) {
  const auto directions = lattice_directions(6);
  const auto triangles = lattice_triangles(6);
  double least = 1e9, most = 0.0;
  for (std::size_t t = 0; t + 1 < triangles.size(); t += 2) {  // the two triangles of a cell
    double cell = 0.0;
    for (const auto& triangle : {triangles[t], triangles[t + 1]})
      cell += spherical_area(directions[triangle[0]], directions[triangle[1]], directions[triangle[2]]);
    least = std::min(least, cell);
    most = std::max(most, cell);
  }
  // The map is equal-area; what is left is the curved cells' sides, drawn here as great circles.
  EXPECT_LT(most / least, 1.15);
}

TEST(OctahedralLattice, LevelsNestByStrideTwo) {
  const auto fine = lattice_directions(5), coarse = lattice_directions(4);
  for (int y = 0; y < lattice_side(4); ++y)
    for (int x = 0; x < lattice_side(4); ++x) EXPECT_EQ(coarse[at(4, x, y)], fine[at(5, 2 * x, 2 * y)]);
}

TEST(OctahedralLattice, GoesOnAcrossItsBordersWhereTheSphereDoes) {
  const int level = 4, last = 1 << level;
  const auto directions = lattice_directions(level);
  // Stepping out of the square and looking up the continued sample stays within two sample distances.
  for (int i = 0; i <= last; ++i)
    for (const auto& [x, y] : {std::pair{i, -1}, {i, last + 1}, {-1, i}, {last + 1, i}}) {
      const auto& inside = directions[at(level, std::clamp(x, 0, last), std::clamp(y, 0, last))];
      EXPECT_LT((directions[continued_sample(level, x, y)] - inside).norm(), 2.0 * std::numbers::pi / last);
    }
}

TEST(OctahedralLattice, RefinedKeepsItsSamplesAndItsBorder) {
  const auto coarse = lattice_directions(3), fine = refine_directions(coarse, 4);
  for (int y = 0; y < lattice_side(3); ++y)
    for (int x = 0; x < lattice_side(3); ++x) EXPECT_EQ(fine[at(4, 2 * x, 2 * y)], coarse[at(3, x, y)]);
  for (const auto& t : lattice_triangles(4)) ASSERT_EQ(orientation(fine[t[0]], fine[t[1]], fine[t[2]]), 1);
  for (int i = 0; i <= 16; ++i) EXPECT_EQ(fine[at(4, i, 0)], fine[at(4, 16 - i, 0)]);
  EXPECT_THROW(refine_directions(coarse, 5), InvalidInput);
}

TEST(OctahedralLattice, RefusesALevelOutOfRange) {
  EXPECT_THROW(lattice_directions(0), InvalidInput);
  EXPECT_THROW(weld_lattice(13), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
