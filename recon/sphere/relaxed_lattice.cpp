#include "recon/sphere/relaxed_lattice.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "recon/sphere/independent_sets.h"
#include "recon/sphere/lattice_settle.h"
#include "recon/sphere/lattice_snap.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/sphere_locator.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

constexpr int kFirstLevel = 3;          // 9 x 9: coarser ones have nothing to follow
constexpr double kNormalLength = 0.15;  // a normal's turn by one radian counts as this share of sqrt(surface area)
constexpr int kPasses = 10;             // at a coarse level
constexpr int kFinePasses = 4;          // from 129 x 129 on

// The lattice of one level on the surface.
class LatticeRelaxation {
 public:
  LatticeRelaxation(const TriangleMesh& mesh, const SphereMap& map, int level, std::vector<Eigen::Vector3d> directions,
                    const std::vector<std::uint32_t>& starts)
      : mesh_(mesh),
        locator_(mesh, map),
        normal_length_(kNormalLength * std::sqrt(surface_area(mesh))),
        lattice_(weld_lattice(level)),
        rings_(rings_of(lattice_.sample_of_vertex.size(), lattice_.triangles)) {
    for (const auto sample : lattice_.sample_of_vertex) {
      points_.push_back(directions[sample]);
      near_.push_back(starts[sample]);
    }
    places_.resize(points_.size());
  }

  void relax(int passes, const std::vector<Eigen::Vector3d>& normals) {
    const auto sets = independent_sets(
        points_.size(), [&](std::uint32_t v) -> const auto& { return rings_[v]; });
    for (int pass = 0; pass < passes; ++pass) {
      read_surface(normals);
      for (const auto& set : sets) tbb::parallel_for(std::size_t{0}, set.size(), [&](std::size_t i) { move(set[i]); });
    }
  }

  std::vector<Eigen::Vector3d> directions() const { return spread(points_); }
  std::vector<std::uint32_t> triangles() const { return spread(near_); }

 private:
  template <class T>
  std::vector<T> spread(const std::vector<T>& of_vertex) const {
    std::vector<T> of_sample;
    of_sample.reserve(lattice_.vertex_of_sample.size());
    for (const auto vertex : lattice_.vertex_of_sample) of_sample.push_back(of_vertex[vertex]);
    return of_sample;
  }

  void read_surface(const std::vector<Eigen::Vector3d>& normals) {
    tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t v) {
      const auto sample = locator_.locate(points_[v], near_[v]);
      near_[v] = sample.triangle;
      const auto& t = mesh_.triangles[sample.triangle];
      const auto& b = sample.barycentric;
      const Eigen::Vector3d normal = b[0] * normals[t[0]] + b[1] * normals[t[1]] + b[2] * normals[t[2]];
      places_[v] << surface_point(mesh_, sample), normal_length_ * normal.normalized();
    });
  }

  // eq. (3), shortened until the vertex stays inside the kernel of its 1-ring.
  void move(std::uint32_t vertex) {
    constexpr double kStep = 0.7;
    std::array<Eigen::Vector3d, 8> corners;  // no vertex of the lattice has more neighbours
    const auto& ring = rings_[vertex];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t j = 0; j < ring.size(); ++j) {
      corners[j] = points_[ring[j]];
      const Eigen::Vector3d edge = corners[j] - points_[vertex];
      const double weight = std::sqrt((places_[ring[j]] - places_[vertex]).norm() / edge.norm());
      sum += weight * edge;
      weights += weight;
    }
    if (!(weights > 0.0)) return;
    points_[vertex] = step_in_kernel(points_[vertex], kStep / weights * sum, {corners.data(), ring.size()});
  }

  const TriangleMesh& mesh_;
  SphereLocator locator_;
  double normal_length_;
  WeldedLattice lattice_;
  std::vector<std::vector<std::uint32_t>> rings_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::uint32_t> near_;                  // the mesh's triangle under each point, or one beside it
  std::vector<Eigen::Matrix<double, 6, 1>> places_;  // position and scaled normal of the surface under each point
};

std::vector<Eigen::Vector3d> normals_of(const TriangleMesh& mesh) {
  TriangleMesh copy{.positions = mesh.positions, .normals = {}, .colours = {}, .triangles = mesh.triangles};
  compute_normals(copy);
  std::vector<Eigen::Vector3d> normals;
  for (const auto& normal : copy.normals) normals.push_back(normal.cast<double>());
  return normals;
}

// For each sample of a level what the coarser level's sample beside it had.
std::vector<std::uint32_t> handed_down(const std::vector<std::uint32_t>& coarse, int level) {
  const auto side = static_cast<std::size_t>(lattice_side(level)), coarse_side = (side + 1) / 2;
  std::vector<std::uint32_t> fine;
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) fine.push_back(coarse[y / 2 * coarse_side + x / 2]);
  return fine;
}

}  // namespace

std::vector<Eigen::Vector3d> relaxed_lattice(const TriangleMesh& mesh, const SphereMap& map, int level) {
  auto directions = lattice_directions(std::min(level, kFirstLevel));
  if (level < kFirstLevel) return directions;
  const auto normals = normals_of(mesh);
  std::vector<std::uint32_t> triangles(directions.size(), 0);
  for (int at = kFirstLevel; at <= level; ++at) {
    if (at > kFirstLevel) {
      directions = refine_directions(directions, at);
      triangles = handed_down(triangles, at);
    }
    LatticeRelaxation relaxation(mesh, map, at, std::move(directions), triangles);
    relaxation.relax(at < 7 ? kPasses : kFinePasses, normals);
    directions = relaxation.directions();
    triangles = relaxation.triangles();
  }
  directions = snap_to_corners(mesh, map, level, directions, triangles);
  return settle_on_creases(mesh, map, level, directions, triangles);
}

}  // namespace rotunda::recon
