#include "recon/mesh/smoothing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

namespace rotunda::recon {
namespace {

using Points = std::vector<Eigen::Vector3d>;

// Every edge of a closed mesh is met once in each direction, so each neighbour is counted once.
void half_step(const TriangleMesh& mesh, Points& points, double factor) {
  Points sums(points.size(), Eigen::Vector3d::Zero());
  std::vector<int> counts(points.size(), 0);
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      sums[t[i]] += points[t[(i + 1) % 3]];
      ++counts[t[i]];
    }
  for (std::size_t v = 0; v < points.size(); ++v)
    if (counts[v] > 0) points[v] += factor * (sums[v] / counts[v] - points[v]);
}

Points area_vectors(const TriangleMesh& mesh, const Points& points) {
  Points normals(points.size(), Eigen::Vector3d::Zero());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d area = 0.5 * (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    for (const auto v : t) normals[v] += area;
  }
  return normals;
}

double volume_of(const TriangleMesh& mesh, const Points& points) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) sum += points[t[0]].dot(points[t[1]].cross(points[t[2]])) / 6.0;
  return sum;
}

// Moves every vertex by the same small distance along its normal; two steps settle the volume.
void restore_volume(const TriangleMesh& mesh, Points& points, double volume) {
  for (int step = 0; step < 2; ++step) {
    const auto normals = area_vectors(mesh, points);
    double area = 0.0;
    for (const auto& n : normals) area += n.norm() / 3.0;
    if (area <= 0.0) return;
    const double distance = (volume - volume_of(mesh, points)) / area;
    for (std::size_t v = 0; v < points.size(); ++v)
      if (const double length = normals[v].norm(); length > 0.0) points[v] += distance / length * normals[v];
  }
}

}  // namespace

void smooth(TriangleMesh& mesh, const SmoothingOptions& options) {
  if (options.rounds <= 0 || mesh.triangles.empty()) return;
  // About the mesh's own middle, so that far-away worlds lose no digits in the volume.
  const Eigen::Vector3d middle = mesh.positions[mesh.triangles[0][0]].cast<double>();
  Points points(mesh.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) points[v] = mesh.positions[v].cast<double>() - middle;
  const double volume = volume_of(mesh, points);
  const double mu = 1.0 / (options.pass_band - 1.0 / options.lambda);  // 1/lambda + 1/mu = pass band
  for (int round = 0; round < options.rounds; ++round) {
    half_step(mesh, points, options.lambda);
    half_step(mesh, points, mu);
  }
  restore_volume(mesh, points, volume);
  for (std::size_t v = 0; v < points.size(); ++v) mesh.positions[v] = (points[v] + middle).cast<float>();
}

}  // namespace rotunda::recon
