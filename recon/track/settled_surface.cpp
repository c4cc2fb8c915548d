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
constexpr int kUnfoldRounds = 48;
constexpr int kRoundsARing = 8;

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

// Vertices of triangles that face against the surface around them, in which every triangle has one voice: a fold's are
// often the largest.
std::vector<std::uint32_t> folded(const TriangleMesh& mesh, std::size_t& folds) {
  std::vector<Eigen::Vector3f> across, around(mesh.positions.size(), Eigen::Vector3f::Zero());
  for (const auto& t : mesh.triangles) {
    const auto& p = mesh.positions;
    across.push_back((p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).normalized());
    for (const auto v : t) around[v] += across.back();
  }
  std::vector<std::uint32_t> vertices;
  folds = 0;
  for (std::size_t i = 0; i < across.size(); ++i) {
    const auto& t = mesh.triangles[i];
    if (across[i].dot(around[t[0]] + around[t[1]] + around[t[2]]) >= 0.0F) continue;
    ++folds;
    vertices.insert(vertices.end(), t.begin(), t.end());
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

void add_ring(const VertexRings& rings, std::vector<std::uint32_t>& vertices) {
  for (std::size_t i = 0, before = vertices.size(); i < before; ++i)
    vertices.insert(vertices.end(), rings[vertices[i]].begin(), rings[vertices[i]].end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
}

// What stays folded is evened out over a wider patch, a ring more every few rounds. Returns the folds that are left.
std::size_t unfold(const VertexRings& rings, TriangleMesh& mesh) {
  std::size_t folds = 0;
  for (int round = 0;; ++round) {
    auto vertices = folded(mesh, folds);
    if (vertices.empty() || round == kUnfoldRounds) break;
    for (int ring = 0; ring < round / kRoundsARing; ++ring) add_ring(rings, vertices);
    for (const auto v : vertices) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const auto neighbour : rings[v]) sum += mesh.positions[neighbour];
      mesh.positions[v] = sum / static_cast<float>(rings[v].size());
    }
  }
  compute_normals(mesh);
  return folds;
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

double uncovered_share(const TriangleMesh& settled, const TriangleMesh& whole) {
  const SurfaceTarget near(settled);
  const auto areas = vertex_areas(whole);
  std::vector<double> bare(areas.size(), 0.0);
  tbb::parallel_for(std::size_t{0}, bare.size(), [&](std::size_t v) {
    const auto at = whole.positions[v].cast<double>(), normal = whole.normals[v].cast<double>();
    if (!near.closest_vertex(at, normal, kGate)) bare[v] = areas[v];
  });
  return std::accumulate(bare.begin(), bare.end(), 0.0) /
         std::max(std::accumulate(areas.begin(), areas.end(), 0.0), 1e-12);
}

}  // namespace

SettledSurface measured(TriangleMesh mesh, const SurfaceTarget& target) {
  SettledSurface result{.mesh = std::move(mesh)};
  measure(target, result);
  result.uncovered = uncovered_share(result.mesh, target.mesh());
  return result;
}

SettledSurface settle(const TriangleMesh& carried, const SurfaceTarget& target, const SettleOptions& options) {
  const VertexRings rings(carried);
  SettledSurface settled{.mesh = carried};
  unfold(rings, settled.mesh);  // skin creases where limbs bend
  const auto normals = settled.mesh.normals;
  for (int round = 0; round < options.rounds; ++round) {
    auto offsets = offsets_to(target, settled.mesh, normals, options.outwards);
    even_out(rings, kSweeps, offsets);
    for (std::size_t v = 0; v < offsets.size(); ++v)
      settled.mesh.positions[v] += static_cast<float>(offsets[v]) * normals[v];
  }
  const auto folds = unfold(rings, settled.mesh);
  settled = measured(std::move(settled.mesh), target);
  settled.folds = folds;
  return settled;
}

}  // namespace rotunda::recon
