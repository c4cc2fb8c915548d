#include "recon/video/lattice_normals.h"

#include <Eigen/Geometry>

namespace rotunda::recon {
namespace {

using Normals = std::vector<Eigen::Vector3f>;

// Twice the area times the normal of every quad, added to its four corners. Outwards: columns cross rows.
Normals sum_of_quads(const Normals& positions, std::size_t side) {
  Normals sums(positions.size(), Eigen::Vector3f::Zero());
  for (std::size_t row = 0; row + 1 < side; ++row)
    for (std::size_t column = 0; column + 1 < side; ++column) {
      const std::size_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      const Eigen::Vector3f quad = (positions[d] - positions[a]).cross(positions[c] - positions[b]);
      for (const std::size_t corner : {a, b, c, d}) sums[corner] += quad;
    }
  return sums;
}

void join(Eigen::Vector3f& a, Eigen::Vector3f& b) {
  a = b = a + b;
}

void join_borders(Normals& sums, std::size_t side) {
  const std::size_t last = side - 1;
  for (std::size_t i = 1; i < side / 2; ++i) {
    join(sums[i], sums[last - i]);
    join(sums[last * side + i], sums[last * side + last - i]);
    join(sums[i * side], sums[(last - i) * side]);
    join(sums[i * side + last], sums[(last - i) * side + last]);
  }
  const std::size_t corners[] = {0, last, last * side, last * side + last};
  Eigen::Vector3f pole = Eigen::Vector3f::Zero();
  for (const std::size_t corner : corners) pole += sums[corner];
  for (const std::size_t corner : corners) sums[corner] = pole;
}

}  // namespace

std::vector<Eigen::Vector3f> lattice_normals(const std::vector<Eigen::Vector3f>& positions, int level) {
  const std::size_t side = (std::size_t{1} << level) + 1;
  Normals normals = sum_of_quads(positions, side);
  join_borders(normals, side);
  for (Eigen::Vector3f& normal : normals) {
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
  return normals;
}

}  // namespace rotunda::recon
