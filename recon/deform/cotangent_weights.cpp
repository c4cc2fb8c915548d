#include "recon/deform/cotangent_weights.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace rotunda::recon {
namespace {

constexpr double kLeast = 0.01, kMost = 10.0;  // angles of 89 and 3 degrees

float corner_weight(const Eigen::Vector3f& at, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3d u = (b - at).cast<double>(), v = (c - at).cast<double>();
  const double sine = std::max(u.cross(v).norm(), std::numeric_limits<double>::min());
  return static_cast<float>(std::clamp(0.5 * u.dot(v) / sine, kLeast, kMost));
}

}  // namespace

std::vector<CornerWeights> cotangent_weights(const TriangleMesh& mesh) {
  std::vector<CornerWeights> weights;
  weights.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const auto& a = mesh.positions[t[0]];
    const auto& b = mesh.positions[t[1]];
    const auto& c = mesh.positions[t[2]];
    weights.push_back({corner_weight(a, b, c), corner_weight(b, c, a), corner_weight(c, a, b)});
  }
  return weights;
}

Eigen::SparseMatrix<double> laplacian(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                                      const std::vector<int>& row, int rows) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(9 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const double w = weights[t][k];
      const int a = row[mesh.triangles[t][(k + 1) % 3]], b = row[mesh.triangles[t][(k + 2) % 3]];
      if (a >= 0) entries.emplace_back(a, a, w);
      if (b >= 0) entries.emplace_back(b, b, w);
      if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), -w);
    }
  Eigen::SparseMatrix<double> lower(rows, rows);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

}  // namespace rotunda::recon
