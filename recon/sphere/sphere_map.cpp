#include "recon/sphere/sphere_map.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "recon/sphere/independent_sets.h"
#include "recon/sphere/progressive_mesh.h"
#include "recon/sphere/spherical_geometry.h"
#include "recon/sphere/vertex_star.h"

namespace rotunda::recon {
namespace {

// The sphere map while vertices come in.
class Embedding {
 public:
  Embedding(const ProgressiveMesh& mesh, const SphereMapOptions& options) : mesh_(mesh), options_(options) {
    points_.reserve(mesh.fine_vertex.size());
    place_tetrahedron(mesh.base[0]);
  }

  // False if a vertex could not be placed; then inserted() tells how far it got.
  bool run() {
    double next_relaxation = 0.0;
    while (!mesh_.done()) {
      if (!insert()) return false;
      const auto count = static_cast<double>(points_.size());
      if (count < next_relaxation) continue;
      relax(options_.passes);
      next_relaxation = count * (count < 1000.0 ? options_.early_growth : options_.growth);
    }
    relax(options_.passes);
    return true;
  }

  const std::vector<Eigen::Vector3d>& points() const { return points_; }
  std::size_t passes() const { return passes_; }

 private:
  void place_tetrahedron(const std::array<std::uint32_t, 3>& face) {
    const double s = 1.0 / std::sqrt(3.0);
    points_ = {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}};
    if (orientation(points_[face[0]], points_[face[1]], points_[face[2]]) < 0) std::swap(points_[2], points_[3]);
  }

  // Fine vertices per corner: a vertex's share in each of its triangles.
  double corner_weight(std::uint32_t vertex) const {
    return static_cast<double>(mesh_.fine_count(vertex)) / static_cast<double>(mesh_.ring(vertex).size());
  }

  // A vertex with its triangles, gathered from all over; one for each thread.
  struct Scratch {
    VertexStar star;
    std::vector<Eigen::Vector3d> ring;
    std::vector<double> weights;
  };

  void gather(std::uint32_t vertex, Scratch& scratch) const {
    const auto& ring = mesh_.ring(vertex);
    scratch.ring.clear();
    for (const auto r : ring) scratch.ring.push_back(points_[r]);
    scratch.weights.clear();
    const double own = corner_weight(vertex);
    for (std::size_t j = 0; j < ring.size(); ++j)
      scratch.weights.push_back(own + corner_weight(ring[j]) + corner_weight(ring[(j + 1) % ring.size()]));
    scratch.star.set(scratch.ring, scratch.weights);
  }

  // The ring around the next vertex is relaxed first if its kernel is too thin.
  bool insert() {
    constexpr int kAttempts = 20;
    const auto ring = mesh_.next_ring();
    std::optional<Eigen::Vector3d> point;
    for (int attempt = 0; attempt < kAttempts && !point; ++attempt) {
      if (attempt > 0)
        for (const auto v : ring) move(v, inserting_);
      auto& corners = inserting_.ring;
      corners.clear();
      for (const auto v : ring) corners.push_back(points_[v]);
      point = kernel_point(corners, points_[ring.front()]);
    }
    if (!point) return false;
    gather(mesh_.split(), inserting_);
    for (int i = 0; i < 2; ++i) point = inserting_.star.improved(*point);
    points_.push_back(*point);
    return true;
  }

  // Gauss-Seidel over the active set, the vertices of an independent set side by side.
  void relax(int passes) {
    const auto sets = independent_sets(
        points_.size(), [&](std::uint32_t v) -> const auto& { return mesh_.ring(v); });
    travelled_.assign(points_.size(), 0.0);
    seen_.assign(points_.size(), -1.0);
    for (int pass = 0; pass < passes; ++pass) {
      ++passes_;
      std::size_t moved = 0;
      for (const auto& set : sets) moved += move_active(set);
      if (moved == 0) return;
    }
  }

  std::size_t move_active(const std::vector<std::uint32_t>& set) {
    constexpr std::size_t kGrain = 128;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, set.size(), kGrain), std::size_t{0},
        [&](const tbb::blocked_range<std::size_t>& range, std::size_t moved) {
          Scratch scratch;
          for (auto i = range.begin(); i < range.end(); ++i) moved += move_if_active(set[i], scratch) ? 1 : 0;
          return moved;
        },
        std::plus<>());
  }

  // A vertex rests until its neighbours have travelled enough to matter.
  bool move_if_active(std::uint32_t vertex, Scratch& scratch) {
    constexpr double kPassedOn = 0.3;  // share of a displacement that wakes the neighbours
    double around = 0.0;
    for (const auto r : mesh_.ring(vertex)) around += travelled_[r];
    if (seen_[vertex] >= 0.0 && kPassedOn * (around - seen_[vertex]) < options_.still) return false;
    seen_[vertex] = around;
    travelled_[vertex] += move(vertex, scratch);
    return true;
  }

  // Displacement as a share of the mean edge.
  double move(std::uint32_t vertex, Scratch& scratch) {
    gather(vertex, scratch);
    const Eigen::Vector3d before = points_[vertex];
    points_[vertex] = scratch.star.improved(before);
    double edges = 0.0;
    for (const auto& r : scratch.ring) edges += (r - before).norm();
    return (points_[vertex] - before).norm() * static_cast<double>(scratch.ring.size()) / edges;
  }

  RefiningMesh mesh_;
  SphereMapOptions options_;
  std::vector<Eigen::Vector3d> points_;
  std::size_t passes_ = 0;
  std::vector<double> travelled_;  // way of each vertex in this relaxation, in its mean edges
  std::vector<double> seen_;       // way of the neighbours when the vertex last moved; negative: never
  Scratch inserting_;
};

// Empty if the mesh has a sphere map.
std::string why_not_a_sphere(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return "mesh has no triangles";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const auto v : mesh.triangles[t]) {
      if (v >= mesh.positions.size())
        return fmt::format("triangle {} names vertex {}, but there are only {}", t, v, mesh.positions.size());
      if (!mesh.positions[v].allFinite()) return fmt::format("position of vertex {} is not a finite number", v);
    }
  const auto topology = topology_of(mesh);
  if (!topology.closed) return "mesh is not closed (an edge has not exactly two triangles that run opposite ways)";
  if (!topology.manifold) return "mesh is not manifold (triangles meet in a single vertex)";
  if (topology.components != 1) return fmt::format("mesh has {} separate surfaces", topology.components);
  if (topology.euler_characteristic != 2)
    return fmt::format("mesh is not of genus 0: it has {} handle(s)", (2 - topology.euler_characteristic) / 2);
  if (mesh.triangles.size() < 4) return "mesh has fewer than four triangles";
  return {};
}

SphereMap in_mesh_order(const TriangleMesh& mesh, const ProgressiveMesh& progressive,
                        const std::vector<Eigen::Vector3d>& points) {
  SphereMap map;
  map.points.assign(mesh.positions.size(), Eigen::Vector3d::UnitZ());
  for (std::size_t v = 0; v < points.size(); ++v) map.points[progressive.fine_vertex[v]] = points[v];
  return map;
}

}  // namespace

SphereMapResult map_to_sphere(const TriangleMesh& mesh, const SphereMapOptions& options) {
  SphereMapResult result;
  auto& report = result.report;
  report.failure = why_not_a_sphere(mesh);
  if (!report.failure.empty()) return result;

  const auto progressive = simplify_to_tetrahedron(mesh);
  Embedding embedding(progressive, options);
  const bool complete = embedding.run();
  report.splits = embedding.points().size() - 4;
  report.passes = embedding.passes();
  if (!complete) {
    report.failure = fmt::format("kernel empty: vertex {} has no room inside its 1-ring",
                                 progressive.fine_vertex[embedding.points().size()]);
    return result;
  }

  auto map = align_to_normals(mesh, in_mesh_order(mesh, progressive, embedding.points()));
  report.flips = flipped_triangles(mesh, map);
  report.area_error = std::abs(spherical_area(mesh, map) - 4.0 * std::numbers::pi);
  report.spread = area_spread(mesh, map);
  if (report.flips > 0)
    report.failure = fmt::format("{} flipped triangle(s) on the sphere", report.flips);
  else if (!(report.area_error <= 1e-9))
    report.failure = fmt::format("spherical areas miss 4 pi by {}", report.area_error);
  else
    result.map = std::move(map);
  return result;
}

std::size_t flipped_triangles(const TriangleMesh& mesh, const SphereMap& map) {
  return static_cast<std::size_t>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
    return orientation(map.points[t[0]], map.points[t[1]], map.points[t[2]]) <= 0;
  }));
}

double spherical_area(const TriangleMesh& mesh, const SphereMap& map) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) sum += spherical_area(map.points[t[0]], map.points[t[1]], map.points[t[2]]);
  return sum;
}

AreaSpread area_spread(const TriangleMesh& mesh, const SphereMap& map) {
  std::vector<double> area(mesh.positions.size(), 0.0);
  std::vector<bool> used(mesh.positions.size(), false);
  for (const auto& t : mesh.triangles) {
    const double third = spherical_area(map.points[t[0]], map.points[t[1]], map.points[t[2]]) / 3.0;
    for (const auto v : t) {
      area[v] += third;
      used[v] = true;
    }
  }
  std::vector<double> shares;
  for (std::size_t v = 0; v < area.size(); ++v)
    if (used[v]) shares.push_back(area[v]);
  if (shares.empty()) return {};
  std::sort(shares.begin(), shares.end());
  const double count = static_cast<double>(shares.size()), mean = 4.0 * std::numbers::pi / count;
  const auto quantile = [&](double q) { return shares[static_cast<std::size_t>(q * (count - 1.0))] / mean; };
  return {shares.front() / mean, quantile(0.05), quantile(0.5), quantile(0.95)};
}

}  // namespace rotunda::recon
