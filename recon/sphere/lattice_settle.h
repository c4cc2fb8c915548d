#pragma once
// Private to recon/sphere: the last step of relaxed_lattice. Edges of the lattice that cross a crease of the surface
// cut its corner or stand off it; here samples move towards their neighbours until edges lie along the creases. Each
// move lowers the sum of e^4 over the sample's 1-ring, e read at two places of every edge and in the middle of every
// triangle: how far the lattice's surface is from the plane of the surface's triangle under it. Samples none of whose e
// is above 12 % of the mean distance of samples stay. Triangles of the lattice stay counter-clockwise (exact).
// Pure; the same result on any number of threads.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

// directions, triangles (of the mesh, near each sample): raster order, as snap_to_corners has them.
std::vector<Eigen::Vector3d> settle_on_creases(const TriangleMesh& mesh, const SphereMap& map, int level,
                                               const std::vector<Eigen::Vector3d>& directions,
                                               const std::vector<std::uint32_t>& triangles);

}  // namespace rotunda::recon
