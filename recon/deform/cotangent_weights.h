#pragma once
// The weights of a mesh's Laplacian: half the cotangent of each triangle's corners (Pinkall, Polthier 1993), kept
// between bounds so that slivers and obtuse triangles of a real scan leave L a matrix whose inverse is positive:
// harmonic fields stay between the values they are given. ALGORITHMS step 13.
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// [k] of a triangle belongs to its corner k and so to the edge between the other two.
using CornerWeights = std::array<float, 3>;
std::vector<CornerWeights> cotangent_weights(const TriangleMesh& mesh);

// L, lower triangle: positive on the diagonal, -w between neighbours; rows and columns of vertices whose `row` is
// negative are left out (they are held), the others stand at their row.
Eigen::SparseMatrix<double> laplacian(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                                      const std::vector<int>& row, int rows);

}  // namespace rotunda::recon
