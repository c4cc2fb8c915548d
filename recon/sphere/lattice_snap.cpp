#include "recon/sphere/lattice_snap.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

constexpr double kMissed = 0.06;  // of the mean distance of samples

class Snapping {
 public:
  Snapping(const TriangleMesh& mesh, const SphereMap& map, int level, const std::vector<Eigen::Vector3d>& directions,
           const std::vector<std::uint32_t>& triangles)
      : mesh_(mesh),
        map_(map),
        surface_(mesh, map),
        lattice_(weld_lattice(level)),
        lattice_mesh_(mesh_of(lattice_)),
        points_(points_of(lattice_, directions)),
        lattice_locator_(lattice_mesh_, points_),
        rings_(rings_of(lattice_.sample_of_vertex.size(), lattice_.triangles)),
        taken_(points_.points.size(), false),
        limit_(kMissed * std::sqrt(surface_area(mesh) / static_cast<double>(points_.points.size()))) {
    for (const auto sample : lattice_.sample_of_vertex) near_.push_back(triangles[sample]);
    for (std::size_t v = 0; v < near_.size(); ++v) {
      const auto sample = surface_.locate(points_.points[v], near_[v]);
      near_[v] = sample.triangle;
      places_.push_back(surface_point(mesh_, sample));
    }
  }

  std::vector<Eigen::Vector3d> run() {
    for (const auto& corner : missed_corners()) snap(corner);
    std::vector<Eigen::Vector3d> directions;
    for (const auto vertex : lattice_.vertex_of_sample) directions.push_back(points_.points[vertex]);
    return directions;
  }

 private:
  struct Corner {
    std::uint32_t vertex = 0;  // of the mesh
    std::uint32_t near = 0;    // the lattice's triangle over it
    double distance = 0.0;
  };

  static TriangleMesh mesh_of(const WeldedLattice& lattice) {
    TriangleMesh mesh;
    mesh.triangles = lattice.triangles;
    return mesh;
  }
  static SphereMap points_of(const WeldedLattice& lattice, const std::vector<Eigen::Vector3d>& directions) {
    SphereMap map;
    for (const auto sample : lattice.sample_of_vertex) map.points.push_back(directions[sample]);
    return map;
  }

  // A triangle of the lattice to start from, for each vertex of the mesh.
  std::vector<std::uint32_t> starts() const {
    std::vector<std::uint32_t> starts(mesh_.positions.size(), 0);
    for (std::uint32_t t = 0; t < lattice_.triangles.size(); ++t)
      for (const auto v : mesh_.triangles[near_[lattice_.triangles[t][0]]]) starts[v] = t;
    return starts;
  }

  // How far the lattice's surface passes a vertex of the mesh by, measured in its triangle over the vertex.
  double distance_at(std::uint32_t vertex, std::uint32_t triangle) const {
    const auto& t = lattice_.triangles[triangle];
    const Eigen::Vector3d &a = places_[t[0]], &b = places_[t[1]], &c = places_[t[2]];
    const Eigen::Vector3d across = (b - a).cross(c - a), to = mesh_.positions[vertex].cast<double>() - a;
    return across.norm() > 0.0 ? std::abs(across.dot(to)) / across.norm() : to.norm();
  }

  std::vector<Corner> missed_corners() const {
    std::vector<bool> used(mesh_.positions.size(), false);
    for (const auto& t : mesh_.triangles)
      for (const auto v : t) used[v] = true;
    const auto from = starts();
    std::vector<Corner> corners(mesh_.positions.size());
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(corners.size()), [&](std::uint32_t v) {
      if (!used[v]) return;
      const auto near = lattice_locator_.locate(map_.points[v], from[v]).triangle;
      corners[v] = {v, near, distance_at(v, near)};
    });
    corners.erase(
        std::remove_if(corners.begin(), corners.end(), [&](const Corner& c) { return !(c.distance > limit_); }),
        corners.end());
    std::stable_sort(corners.begin(), corners.end(),
                     [](const Corner& a, const Corner& b) { return a.distance > b.distance; });
    return corners;
  }

  void snap(const Corner& corner) {
    const auto& direction = map_.points[corner.vertex];
    const auto over = lattice_locator_.locate(direction, corner.near);
    const double distance = distance_at(corner.vertex, over.triangle);
    if (distance <= limit_) return;  // a neighbour's move was enough
    std::array<int, 3> nearest_first = {0, 1, 2};
    std::sort(nearest_first.begin(), nearest_first.end(),
              [&](int a, int b) { return over.barycentric[a] > over.barycentric[b]; });
    for (const auto k : nearest_first) {
      const auto sample = lattice_.triangles[over.triangle][static_cast<std::size_t>(k)];
      if (taken_[sample] || !may_move(sample, corner.vertex, distance)) continue;
      points_.points[sample] = direction;
      places_[sample] = mesh_.positions[corner.vertex].cast<double>();
      taken_[sample] = true;
      return;
    }
  }

  bool may_move(std::uint32_t sample, std::uint32_t vertex, double distance) const {
    std::vector<Eigen::Vector3d> corners;
    for (const auto r : rings_[sample]) corners.push_back(points_.points[r]);
    if (!inside_kernel(map_.points[vertex], corners)) return false;
    const double before = deepest_cut(sample, points_.points[sample], places_[sample]);
    const double after = deepest_cut(sample, map_.points[vertex], mesh_.positions[vertex].cast<double>());
    return after <= std::max(before, distance);
  }

  // How far the surface lies from the edges of a sample that is put to `direction`, where it is at `place`.
  double deepest_cut(std::uint32_t sample, const Eigen::Vector3d& direction, const Eigen::Vector3d& place) const {
    double deepest = 0.0;
    for (const auto r : rings_[sample])
      for (const double share : {1.0 / 3.0, 2.0 / 3.0}) {
        const Eigen::Vector3d between = ((1.0 - share) * direction + share * points_.points[r]).normalized();
        const Eigen::Vector3d to = surface_point(mesh_, surface_.locate(between, near_[sample])) - place;
        const Eigen::Vector3d edge = places_[r] - place;
        const double along = edge.squaredNorm() > 0.0 ? std::clamp(to.dot(edge) / edge.squaredNorm(), 0.0, 1.0) : 0.0;
        deepest = std::max(deepest, (to - along * edge).norm());
      }
    return deepest;
  }

  const TriangleMesh& mesh_;
  const SphereMap& map_;
  SphereLocator surface_;
  WeldedLattice lattice_;
  TriangleMesh lattice_mesh_;  // triangles alone
  SphereMap points_;           // of the lattice's vertices
  SphereLocator lattice_locator_;
  std::vector<std::vector<std::uint32_t>> rings_;
  std::vector<bool> taken_;
  double limit_;                         // metres
  std::vector<std::uint32_t> near_;      // triangle of the mesh by each vertex of the lattice
  std::vector<Eigen::Vector3d> places_;  // of the lattice's vertices on the surface
};

}  // namespace

Eigen::Vector3d surface_point(const TriangleMesh& mesh, const SurfaceSample& sample) {
  const auto& t = mesh.triangles[sample.triangle];
  return sample.barycentric[0] * mesh.positions[t[0]].cast<double>() +
         sample.barycentric[1] * mesh.positions[t[1]].cast<double>() +
         sample.barycentric[2] * mesh.positions[t[2]].cast<double>();
}

std::vector<std::vector<std::uint32_t>> rings_of(std::size_t vertex_count,
                                                 const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<std::vector<std::array<std::uint32_t, 2>>> sides(vertex_count);
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) sides[t[i]].push_back({t[(i + 1) % 3], t[(i + 2) % 3]});
  std::vector<std::vector<std::uint32_t>> rings(vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    auto at = sides[v].empty() ? 0 : sides[v].front()[0];
    for (std::size_t count = 0; count < sides[v].size(); ++count) {
      rings[v].push_back(at);
      at = (*std::find_if(sides[v].begin(), sides[v].end(), [&](const auto& side) { return side[0] == at; }))[1];
    }
  }
  return rings;
}

std::vector<Eigen::Vector3d> snap_to_corners(const TriangleMesh& mesh, const SphereMap& map, int level,
                                             const std::vector<Eigen::Vector3d>& directions,
                                             const std::vector<std::uint32_t>& triangles) {
  return Snapping(mesh, map, level, directions, triangles).run();
}

}  // namespace rotunda::recon
