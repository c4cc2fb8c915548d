#pragma once
// The closed octahedral lattice: a subdivided octahedron unfolded to a square of (2^level + 1)^2 samples (Praun, Hoppe
// 2003, section 5). Sample (x, y) is column x, row y; raster index y * side + x. One pole (+z) is the square's centre,
// the other (-z) its four corners, the equator's four octahedron vertices are the midpoints of its sides. On each
// border line sample i is the same point as sample side-1-i. Level n is every second sample of level n+1.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace rotunda::recon {

constexpr int kMinLatticeLevel = 1;   // the octahedron itself
constexpr int kMaxLatticeLevel = 12;  // 4097 samples a side

// Throws InvalidInput if the level is out of range; so do the functions below.
void check_lattice_level(int level);

constexpr int lattice_side(int level) {
  return (1 << level) + 1;
}
constexpr std::size_t lattice_size(int level) {
  return static_cast<std::size_t>(lattice_side(level)) * static_cast<std::size_t>(lattice_side(level));
}

// The level of a lattice of so many samples.
int lattice_level(std::size_t samples);

// Raster index of the one sample that stands for (x, y) and all samples identified with it.
std::uint32_t canonical_sample(int level, int x, int y);

// Raster index of the sample at (x, y) where x or y may lie outside by less than a side: the surface goes on there,
// turned by 180 degrees about the midpoint of the crossed side.
std::uint32_t continued_sample(int level, int x, int y);

// Unit directions, raster order, bitwise equal on identified samples. Equal-area in each octant (Rosca, Plonka 2011;
// Clarberg 2008), so that uniform sampling of the square is uniform on the sphere.
std::vector<Eigen::Vector3d> lattice_directions(int level);

// Directions of a lattice from those of the next coarser one: its samples, and between them the middles of the edges of
// its triangles. Triangles that are counter-clockwise stay so. level: of the result.
std::vector<Eigen::Vector3d> refine_directions(const std::vector<Eigen::Vector3d>& coarse, int level);

// The 2 * 4^level triangles as raster indices, counter-clockwise from outside, border samples not joined: for drawing.
std::vector<std::array<std::uint32_t, 3>> lattice_triangles(int level);

// The same surface closed: 4^level + 2 vertices, chi = 2.
struct WeldedLattice {
  std::vector<std::uint32_t> sample_of_vertex;  // canonical raster index
  std::vector<std::uint32_t> vertex_of_sample;  // for every raster index
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
WeldedLattice weld_lattice(int level);

}  // namespace rotunda::recon
