#include "recon/track/settled_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "recon/track/surface_registration.h"
#include "recon/track/surface_smoothing.h"

namespace rotunda::recon {
namespace {

constexpr double kGate = 0.05;       // metres
constexpr double kFarthest = 0.015;  // metres a round
constexpr int kSweeps = 4;           // of evening out: over about 3 cm of a surface of 20 000 triangles
constexpr int kUnfoldRounds = 30;

// How far along its normal each vertex is from the surface, as far as that is to be believed.
std::vector<double> offsets_to(const SurfaceTarget& target, const TriangleMesh& mesh,
                               const std::vector<Eigen::Vector3f>& normals, double outwards) {
  std::vector<double> offsets(mesh.positions.size(), 0.0);
  tbb::parallel_for(std::size_t{0}, offsets.size(), [&](std::size_t v) {
    const Eigen::Vector3d at = mesh.positions[v].cast<double>(), normal = normals[v].cast<double>();
    const auto hit = target.closest(at, normal, kGate);
    if (!hit) return;
    const double way = std::clamp(normal.dot(hit->point - at), -kFarthest, kFarthest);
    offsets[v] = way > 0.0 ? outwards * way : way;
  });
  return offsets;
}

// Vertices of triangles that face against the normals of what was carried there.
std::vector<std::uint32_t> folded(const TriangleMesh& mesh, const std::vector<Eigen::Vector3f>& normals,
                                  std::size_t& folds) {
  std::vector<std::uint32_t> vertices;
  folds = 0;
  for (const auto& t : mesh.triangles) {
    const auto& p = mesh.positions;
    const Eigen::Vector3f across = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
    if (across.dot(normals[t[0]] + normals[t[1]] + normals[t[2]]) >= 0.0F) continue;
    ++folds;
    vertices.insert(vertices.end(), t.begin(), t.end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

void unfold(const VertexRings& rings, const std::vector<Eigen::Vector3f>& normals, SettledSurface& settled) {
  auto& positions = settled.mesh.positions;
  for (int round = 0; round < kUnfoldRounds; ++round) {
    const auto vertices = folded(settled.mesh, normals, settled.folds);
    if (vertices.empty()) return;
    for (const auto v : vertices) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const auto neighbour : rings[v]) sum += positions[neighbour];
      positions[v] = sum / static_cast<float>(rings[v].size());
    }
  }
}

void measure(const SurfaceTarget& target, SettledSurface& settled) {
  constexpr double kAnywhere = 1.0;
  const auto& mesh = settled.mesh;
  std::vector<double> distances(mesh.positions.size(), kAnywhere);
  tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t v) {
    const auto hit = target.closest(mesh.positions[v].cast<double>(), mesh.normals[v].cast<double>(), kAnywhere);
    if (hit) distances[v] = hit->distance;
  });
  const auto areas = vertex_areas(mesh);
  const double area = std::max(std::accumulate(areas.begin(), areas.end(), 0.0), 1e-12);
  std::vector<std::uint32_t> order(distances.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return distances[a] < distances[b]; });
  double below = 0.0;
  for (const auto v : order) {
    settled.residual_mean_mm += 1e3 * distances[v] * areas[v] / area;
    if (below < 0.95 * area) settled.residual_p95_mm = 1e3 * distances[v];
    below += areas[v];
  }
}

}  // namespace

SettledSurface settle(const TriangleMesh& carried, const SurfaceTarget& target, const SettleOptions& options) {
  const VertexRings rings(carried);
  SettledSurface settled{.mesh = carried};
  for (int round = 0; round < options.rounds; ++round) {
    auto offsets = offsets_to(target, settled.mesh, carried.normals, options.outwards);
    even_out(rings, kSweeps, offsets);
    for (std::size_t v = 0; v < offsets.size(); ++v)
      settled.mesh.positions[v] += static_cast<float>(offsets[v]) * carried.normals[v];
  }
  unfold(rings, carried.normals, settled);
  compute_normals(settled.mesh);
  measure(target, settled);
  return settled;
}

}  // namespace rotunda::recon
