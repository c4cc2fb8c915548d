#include "recon/sphere/octahedral_lattice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

std::uint32_t raster(int level, int x, int y) {
  return static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(lattice_side(level)) +
         static_cast<std::uint32_t>(x);
}

// Equal-area map of the square [-1, 1]^2 onto the sphere. |u| + |v| = 1 is the equator.
Eigen::Vector3d direction_at(double u, double v) {
  const double height = 1.0 - (std::abs(u) + std::abs(v));               // > 0: northern half
  const double r = 1.0 - std::abs(height);                               // 0 at the poles, 1 on the equator
  const double along = height >= 0.0 ? std::abs(v) : 1.0 - std::abs(u);  // 0 ... r, from the x to the y axis
  const double angle = r > 0.0 ? along / r * std::numbers::pi / 2.0 : 0.0;
  const double radius = r * std::sqrt(2.0 - r * r);
  const double z = std::copysign(1.0 - r * r, height);
  return {std::copysign(radius * std::cos(angle), u), std::copysign(radius * std::sin(angle), v), z};
}

// Cells are cut along the octahedron's edges, which cross the first and third quadrant as x + y = const.
bool cut_against_raster(int cells, int x, int y) {
  return (2 * x < cells) == (2 * y < cells);
}

}  // namespace

void check_lattice_level(int level) {
  if (level < kMinLatticeLevel || level > kMaxLatticeLevel)
    throw InvalidInput("lattice level " + std::to_string(level) + " is not between " +
                       std::to_string(kMinLatticeLevel) + " and " + std::to_string(kMaxLatticeLevel));
}

int lattice_level(std::size_t samples) {
  for (int level = kMinLatticeLevel; level <= kMaxLatticeLevel; ++level)
    if (lattice_size(level) == samples) return level;
  throw InvalidInput("a lattice has (2^n + 1)^2 samples, not " + std::to_string(samples));
}

std::uint32_t canonical_sample(int level, int x, int y) {
  const int last = 1 << level;
  const bool on_row = y == 0 || y == last, on_column = x == 0 || x == last;
  if (on_row && on_column) return 0;
  if (on_row) x = std::min(x, last - x);
  if (on_column) y = std::min(y, last - y);
  return raster(level, x, y);
}

std::uint32_t continued_sample(int level, int x, int y) {
  const int last = 1 << level;
  if (y < 0 || y > last) {
    y = y < 0 ? -y : 2 * last - y;
    x = last - x;
  }
  if (x < 0 || x > last) {
    x = x < 0 ? -x : 2 * last - x;
    y = last - y;
  }
  return raster(level, x, y);
}

std::vector<Eigen::Vector3d> lattice_directions(int level) {
  check_lattice_level(level);
  const int side = lattice_side(level);
  const double half = 0.5 * (side - 1);
  std::vector<Eigen::Vector3d> directions(lattice_size(level));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto from = canonical_sample(level, x, y);  // never later in the raster
      const auto at = raster(level, x, y);
      directions[at] = from == at ? direction_at(x / half - 1.0, y / half - 1.0) : directions[from];
    }
  return directions;
}

std::vector<Eigen::Vector3d> refine_directions(const std::vector<Eigen::Vector3d>& coarse, int level) {
  check_lattice_level(level);
  if (level == kMinLatticeLevel || coarse.size() != lattice_size(level - 1))
    throw InvalidInput("directions to refine to level " + std::to_string(level) + " must be of the level below");
  const int side = lattice_side(level), coarse_cells = 1 << (level - 1);
  const auto at = [&](int x, int y) -> const Eigen::Vector3d& { return coarse[raster(level - 1, x, y)]; };
  std::vector<Eigen::Vector3d> fine(lattice_size(level));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto from = canonical_sample(level, x, y), sample = raster(level, x, y);
      const int left = x / 2, right = (x + 1) / 2, top = y / 2, bottom = (y + 1) / 2;
      const bool against = left != right && top != bottom && cut_against_raster(coarse_cells, left, top);
      const Eigen::Vector3d sum = against ? Eigen::Vector3d(at(right, top) + at(left, bottom))
                                          : Eigen::Vector3d(at(left, top) + at(right, bottom));
      if (from != sample)
        fine[sample] = fine[from];
      else
        fine[sample] = left == right && top == bottom ? at(left, top) : sum.normalized();
    }
  return fine;
}

std::vector<std::array<std::uint32_t, 3>> lattice_triangles(int level) {
  check_lattice_level(level);
  const int cells = 1 << level;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(2 * static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const auto a = raster(level, x, y), b = raster(level, x + 1, y), c = raster(level, x + 1, y + 1),
                 d = raster(level, x, y + 1);
      if (cut_against_raster(cells, x, y)) {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      } else {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      }
    }
  return triangles;
}

WeldedLattice weld_lattice(int level) {
  WeldedLattice lattice;
  lattice.triangles = lattice_triangles(level);
  lattice.vertex_of_sample.resize(lattice_size(level));
  const int side = lattice_side(level);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto from = canonical_sample(level, x, y), at = raster(level, x, y);
      if (from != at) {
        lattice.vertex_of_sample[at] = lattice.vertex_of_sample[from];
        continue;
      }
      lattice.vertex_of_sample[at] = static_cast<std::uint32_t>(lattice.sample_of_vertex.size());
      lattice.sample_of_vertex.push_back(at);
    }
  for (auto& triangle : lattice.triangles)
    for (auto& corner : triangle) corner = lattice.vertex_of_sample[corner];
  return lattice;
}

}  // namespace rotunda::recon
