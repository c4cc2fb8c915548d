#include "recon/sphere/lattice_fit.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "recon/sphere/lattice_snap.h"
#include "recon/sphere/octahedral_lattice.h"

namespace rotunda::recon {
namespace {

constexpr int kIterations = 8;     // each leaves less than half of the error
constexpr double kSample = 2.0;    // weight of a sample beside an edge's middle: creases bend less than all around
constexpr double kFarthest = 0.3;  // of an edge's length: beyond that the edge spans a gap, not a curve

struct Edge {
  std::uint32_t a = 0, b = 0;           // welded vertices
  double beyond = 0.0;                  // r, metres
  double along_a = 0.0, along_b = 0.0;  // c
};

std::vector<Edge> edges_of(const WeldedLattice& lattice) {
  std::vector<Edge> edges;
  for (const auto& t : lattice.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (t[i] < t[(i + 1) % 3]) edges.push_back({t[i], t[(i + 1) % 3]});
  return edges;
}

std::vector<double> ways_along_normals(const std::vector<Edge>& edges, std::size_t vertices) {
  std::vector<std::vector<std::uint32_t>> edges_at(vertices);
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    edges_at[edges[e].a].push_back(e);
    edges_at[edges[e].b].push_back(e);
  }
  std::vector<double> way(vertices, 0.0), next(way);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    tbb::parallel_for(std::size_t{0}, way.size(), [&](std::size_t v) {
      double weight = kSample, sum = 0.0;
      for (const auto e : edges_at[v]) {
        const auto& edge = edges[e];
        const bool is_a = edge.a == v;
        const double own = 0.5 * (is_a ? edge.along_a : edge.along_b);
        const double other = 0.5 * (is_a ? edge.along_b * way[edge.b] : edge.along_a * way[edge.a]);
        weight += own * own;
        sum += own * (edge.beyond - other);
      }
      next[v] = sum / weight;
    });
    way.swap(next);
  }
  return way;
}

}  // namespace

void fit_positions(const TriangleMesh& mesh, const SphereLocator& locator,
                   const std::vector<Eigen::Vector3d>& directions, const std::vector<SurfaceSample>& samples,
                   const std::vector<Eigen::Vector3f>& normals, std::vector<Eigen::Vector3f>& positions) {
  const auto lattice = weld_lattice(lattice_level(directions.size()));
  const auto& at = lattice.sample_of_vertex;
  auto edges = edges_of(lattice);
  tbb::parallel_for(std::size_t{0}, edges.size(), [&](std::size_t e) {
    auto& edge = edges[e];
    const auto a = at[edge.a], b = at[edge.b];
    const auto middle = locator.locate((directions[a] + directions[b]).normalized(), samples[a].triangle);
    const Eigen::Vector3d from = positions[a].cast<double>(), to = positions[b].cast<double>();
    const auto& t = mesh.triangles[middle.triangle];
    const Eigen::Vector3d p = mesh.positions[t[0]].cast<double>(), q = mesh.positions[t[1]].cast<double>(),
                          r = mesh.positions[t[2]].cast<double>();
    const Eigen::Vector3d normal = (q - p).cross(r - p).normalized();
    const double farthest = kFarthest * (to - from).norm();
    edge.beyond = std::clamp(normal.dot(surface_point(mesh, middle) - 0.5 * (from + to)), -farthest, farthest);
    edge.along_a = normal.dot(normals[a].cast<double>());
    edge.along_b = normal.dot(normals[b].cast<double>());
  });
  const auto way = ways_along_normals(edges, at.size());
  for (std::size_t v = 0; v < at.size(); ++v) positions[at[v]] += static_cast<float>(way[v]) * normals[at[v]];
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = positions[at[lattice.vertex_of_sample[i]]];
}

}  // namespace rotunda::recon
