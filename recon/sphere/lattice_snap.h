#pragma once
// Private to recon/sphere: the step of relaxed_lattice before its last, and what its steps share.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/sphere_locator.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

Eigen::Vector3d surface_point(const TriangleMesh& mesh, const SurfaceSample& sample);

// 1-rings, counter-clockwise, of a closed manifold mesh.
std::vector<std::vector<std::uint32_t>> rings_of(std::size_t vertex_count,
                                                 const std::vector<std::array<std::uint32_t, 3>>& triangles);

// Samples moved onto vertices of the surface that the lattice misses by more than 6 % of the mean distance of samples,
// worst first; not where the sample's edges would then cut through the surface deeper than the vertex was missed by.
// directions, triangles (of the mesh, near each sample): raster order.
std::vector<Eigen::Vector3d> snap_to_corners(const TriangleMesh& mesh, const SphereMap& map, int level,
                                             const std::vector<Eigen::Vector3d>& directions,
                                             const std::vector<std::uint32_t>& triangles);

}  // namespace rotunda::recon
