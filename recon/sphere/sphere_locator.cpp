#include "recon/sphere/sphere_locator.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "recon/sphere/spherical_geometry.h"

namespace rotunda::recon {
namespace {

std::vector<std::array<std::uint32_t, 3>> neighbours_of(const TriangleMesh& mesh) {
  struct EdgeSide {
    std::uint32_t low, high, triangle, side;
  };
  std::vector<EdgeSide> sides;
  sides.reserve(mesh.triangles.size() * 3);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]);
      sides.push_back({low, high, t, i});
    }
  std::sort(sides.begin(), sides.end(),
            [](const EdgeSide& a, const EdgeSide& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  std::vector<std::array<std::uint32_t, 3>> across(mesh.triangles.size());
  for (std::size_t e = 0; e + 1 < sides.size(); e += 2) {  // closed: the two sides of an edge are neighbours here
    across[sides[e].triangle][sides[e].side] = sides[e + 1].triangle;
    across[sides[e + 1].triangle][sides[e + 1].side] = sides[e].triangle;
  }
  return across;
}

}  // namespace

SphereLocator::SphereLocator(const TriangleMesh& mesh, const SphereMap& map)
    : mesh_(mesh), map_(map), across_(neighbours_of(mesh)) {}

SurfaceSample SphereLocator::locate(const Eigen::Vector3d& direction, std::uint32_t start) const {
  const auto found = walk(direction, start);
  const auto& t = mesh_.triangles[found];
  const auto &a = map_.points[t[0]], &b = map_.points[t[1]], &c = map_.points[t[2]];
  const Eigen::Vector3d to_a = a - direction, to_b = b - direction, to_c = c - direction;
  const Eigen::Vector3d weights(direction.dot(to_b.cross(to_c)), direction.dot(to_c.cross(to_a)),
                                direction.dot(to_a.cross(to_b)));
  const Eigen::Vector3d inside = weights.cwiseMax(0.0);
  const double sum = inside.sum();
  return {found, sum > 0.0 ? Eigen::Vector3d(inside / sum) : Eigen::Vector3d::Constant(1.0 / 3.0)};
}

bool SphereLocator::holds(std::uint32_t triangle, const Eigen::Vector3d& direction) const {
  const auto& t = mesh_.triangles[triangle];
  for (std::size_t i = 0; i < 3; ++i)
    if (orientation(direction, map_.points[t[i]], map_.points[t[(i + 1) % 3]]) < 0) return false;
  return true;
}

std::uint32_t SphereLocator::walk(const Eigen::Vector3d& direction, std::uint32_t start) const {
  auto at = start;
  // The first edge looked at changes from step to step: a fixed order could go round in circles.
  for (std::size_t step = 0; step < mesh_.triangles.size(); ++step) {
    const auto& t = mesh_.triangles[at];
    std::size_t out = 3;
    for (std::size_t k = 0; k < 3 && out == 3; ++k) {
      const std::size_t i = (step + k) % 3;
      if (orientation(direction, map_.points[t[i]], map_.points[t[(i + 1) % 3]]) < 0) out = i;
    }
    if (out == 3) return at;
    at = across_[at][out];
  }
  for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
    if (holds(t, direction)) return t;
  return at;
}

}  // namespace rotunda::recon
