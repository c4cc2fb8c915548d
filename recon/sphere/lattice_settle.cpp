#include "recon/sphere/lattice_settle.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "recon/sphere/independent_sets.h"
#include "recon/sphere/lattice_snap.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/sphere_locator.h"
#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

constexpr double kOff = 0.12;   // of the mean distance of samples
constexpr int kPasses = 6;      // the last moves one sample in a hundred of the first
constexpr double kGain = 0.98;  // a move that lowers the sum by less is not worth waking the neighbours

class Settling {
 public:
  Settling(const TriangleMesh& mesh, const SphereMap& map, int level, const std::vector<Eigen::Vector3d>& directions,
           const std::vector<std::uint32_t>& triangles)
      : mesh_(mesh),
        surface_(mesh, map),
        lattice_(weld_lattice(level)),
        rings_(rings_of(lattice_.sample_of_vertex.size(), lattice_.triangles)),
        limit_(kOff * std::sqrt(surface_area(mesh) / static_cast<double>(rings_.size()))),
        spots_(rings_.size()) {
    tbb::parallel_for(std::size_t{0}, spots_.size(), [&](std::size_t v) {
      const auto sample = lattice_.sample_of_vertex[v];
      spots_[v] = spot_at(directions[sample], triangles[sample]);
    });
  }

  std::vector<Eigen::Vector3d> run() {
    const auto sets = independent_sets(
        spots_.size(), [&](std::uint32_t v) -> const auto& { return rings_[v]; });
    std::vector<char> awake(spots_.size(), 1), moved;  // not bool: written side by side
    for (int pass = 0; pass < kPasses; ++pass) {
      moved.assign(spots_.size(), 0);
      for (const auto& set : sets)
        tbb::parallel_for(std::size_t{0}, set.size(), [&](std::size_t i) {
          if (awake[set[i]]) moved[set[i]] = settle(set[i]);
        });
      awake = with_neighbours(moved);
    }
    std::vector<Eigen::Vector3d> directions;
    for (const auto vertex : lattice_.vertex_of_sample) directions.push_back(spots_[vertex].direction);
    return directions;
  }

 private:
  struct Spot {
    Eigen::Vector3d direction, place;  // on the sphere; on the surface, metres
    std::uint32_t triangle = 0;        // of the mesh
  };
  struct Deviation {
    double sum = 0.0;   // of (e / limit)^4
    double most = 0.0;  // e, metres
  };

  Spot spot_at(const Eigen::Vector3d& direction, std::uint32_t near) const {
    const auto sample = surface_.locate(direction, near);
    return {direction, surface_point(mesh_, sample), sample.triangle};
  }

  std::vector<char> with_neighbours(const std::vector<char>& of) const {
    auto all = of;
    for (std::uint32_t v = 0; v < of.size(); ++v)
      if (of[v])
        for (const auto r : rings_[v]) all[r] = 1;
    return all;
  }

  // e of a point of the lattice's surface over `direction`, of any length.
  double off_surface(const Eigen::Vector3d& direction, const Eigen::Vector3d& place, std::uint32_t near) const {
    const auto& t = mesh_.triangles[surface_.locate(direction.normalized(), near).triangle];
    const Eigen::Vector3d a = mesh_.positions[t[0]].cast<double>(), b = mesh_.positions[t[1]].cast<double>(),
                          c = mesh_.positions[t[2]].cast<double>();
    const Eigen::Vector3d across = (b - a).cross(c - a);
    const double length = across.norm();
    return length > 0.0 ? std::abs(across.dot(place - a)) / length : 0.0;
  }

  // Of the 1-ring with its vertex at `spot`; not to the end once the sum is above `enough`.
  Deviation deviation(std::uint32_t vertex, const Spot& spot,
                      double enough = std::numeric_limits<double>::infinity()) const {
    Deviation all;
    const auto add = [&](const Eigen::Vector3d& direction, const Eigen::Vector3d& place) {
      const double e = off_surface(direction, place, spot.triangle), share = e / limit_;
      all.most = std::max(all.most, e);
      all.sum += share * share * share * share;
    };
    const auto& ring = rings_[vertex];
    for (std::size_t j = 0; j < ring.size() && all.sum < enough; ++j) {
      const auto &a = spots_[ring[j]], &b = spots_[ring[(j + 1) % ring.size()]];
      for (const double s : {1.0 / 3.0, 2.0 / 3.0})
        add((1.0 - s) * spot.direction + s * a.direction, (1.0 - s) * spot.place + s * a.place);
      add(spot.direction + a.direction + b.direction, (spot.place + a.place + b.place) / 3.0);
    }
    return all;
  }

  bool settle(std::uint32_t vertex) {
    const Spot from = spots_[vertex];
    const auto now = deviation(vertex, from);
    if (now.most < limit_) return false;
    std::array<Eigen::Vector3d, 8> corners;  // no vertex of the lattice has more neighbours
    const auto& ring = rings_[vertex];
    for (std::size_t j = 0; j < ring.size(); ++j) corners[j] = spots_[ring[j]].direction;
    double enough = kGain * now.sum;
    bool moves = false;
    for (std::size_t j = 0; j < ring.size(); ++j)
      for (const double share : {0.1, 0.25, 0.5}) {
        const Eigen::Vector3d direction = ((1.0 - share) * from.direction + share * corners[j]).normalized();
        if (!inside_kernel(direction, {corners.data(), ring.size()})) continue;
        const auto candidate = spot_at(direction, from.triangle);
        const double sum = deviation(vertex, candidate, enough).sum;
        if (sum >= enough) continue;
        enough = kGain * sum;
        spots_[vertex] = candidate;
        moves = true;
      }
    return moves;
  }

  const TriangleMesh& mesh_;
  SphereLocator surface_;
  WeldedLattice lattice_;
  std::vector<std::vector<std::uint32_t>> rings_;
  double limit_;             // metres
  std::vector<Spot> spots_;  // of the lattice's vertices
};

}  // namespace

std::vector<Eigen::Vector3d> settle_on_creases(const TriangleMesh& mesh, const SphereMap& map, int level,
                                               const std::vector<Eigen::Vector3d>& directions,
                                               const std::vector<std::uint32_t>& triangles) {
  return Settling(mesh, map, level, directions, triangles).run();
}

}  // namespace rotunda::recon
