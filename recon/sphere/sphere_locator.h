#pragma once
// Finds the spherical triangle of a one-to-one sphere map that holds a direction: a visibility walk (Devillers, Pion,
// Teillaud 2001) from triangle to triangle with the exact orientation predicate.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

// A point of a mesh's surface.
struct SurfaceSample {
  std::uint32_t triangle = 0;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  // >= 0, sum 1, in the order of the triangle's corners
};

class SphereLocator {
 public:
  // Keeps references to both. The mesh is closed and the map one-to-one (map_to_sphere says so).
  SphereLocator(const TriangleMesh& mesh, const SphereMap& map);

  // Every direction is found; a `start` triangle nearby makes it quick.
  SurfaceSample locate(const Eigen::Vector3d& direction, std::uint32_t start = 0) const;

 private:
  bool holds(std::uint32_t triangle, const Eigen::Vector3d& direction) const;
  std::uint32_t walk(const Eigen::Vector3d& direction, std::uint32_t start) const;

  const TriangleMesh& mesh_;
  const SphereMap& map_;
  std::vector<std::array<std::uint32_t, 3>> across_;  // across edge (i, i + 1): the next triangle
};

}  // namespace rotunda::recon
