#pragma once
// Private to recon/sphere: the last step of resampling. A lattice whose samples lie on a curved surface has its
// triangles inside it everywhere: an error of one sign. Here each sample moves along its normal until triangles and
// surface cross, in the least-squares sense,
//     min sum_e ( r_e - (c_ea d_a + c_eb d_b) / 2 )^2 + 2 sum_i d_i^2 ,   c_ea = n_e . N_a ,
// d_i the way of sample i along its normal N_i; for every edge e = (a, b) of the lattice r_e is how far the surface
// lies beyond the edge's middle, along the surface's normal n_e there. By Jacobi's iteration: the same on any number of
// threads.
#include <Eigen/Core>
#include <vector>

#include "recon/sphere/sphere_locator.h"

namespace rotunda::recon {

// positions, normals (unit): in raster order, of the samples under `directions`; border samples stay equal.
void fit_positions(const TriangleMesh& mesh, const SphereLocator& locator,
                   const std::vector<Eigen::Vector3d>& directions, const std::vector<SurfaceSample>& samples,
                   const std::vector<Eigen::Vector3f>& normals, std::vector<Eigen::Vector3f>& positions);

}  // namespace rotunda::recon
