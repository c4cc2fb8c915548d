#pragma once
// The octahedral lattice relaxed so that its density follows a mapped surface (ALGORITHMS.md step 6; Zhou, Bao, Shum
// 2004): many samples where the surface is wide on the sphere or bends, few where it is narrow and flat. Eq. (3),
//     Delta(s_i) = sum_i' w_i' (s_i' - s_i) / sum_i' w_i' ,   w_i' = D0(s_i') / D(s_i') ,
// with the density read along each edge: w_i' = sqrt(|X_i' - X_i| / |s_i' - s_i|), X the surface's position and, scaled
// to a length, its normal. From coarse to fine, starting from the equal-area octant map. Last, samples next to corners
// of the surface that the lattice would cut off are put upon them, and edges that cross creases are turned along them.
// Triangles of the lattice stay counter-clockwise (exact). Pure; the same result on any number of threads.
#include <Eigen/Core>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/sphere/sphere_map.h"

namespace rotunda::recon {

// Unit directions, raster order, bitwise equal on identified samples. The map must be one-to-one and of this mesh.
// Throws InvalidInput if the level is out of range.
std::vector<Eigen::Vector3d> relaxed_lattice(const TriangleMesh& mesh, const SphereMap& map, int level);

}  // namespace rotunda::recon
