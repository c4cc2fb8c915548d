#pragma once
// Harmonic fields over a mesh that tell how much each handle turns each vertex (Zayer, Roessl, Karni, Seidel 2005; de
// Aguiar et al. 2007, 4): Laplace(S) = 0 with S given at the held vertices. The four components of a quaternion field
// are linear in the handles' quaternions, so that the fields of the handles' indicators, solved once, serve every
// frame: q(v) = sum of share(v, h) q(h).
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "recon/deform/cotangent_weights.h"
#include "recon/deform/sparse_factor.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// A vertex that moves as a handle does (a rigid part of the body that a motion tells of).
struct HeldVertex {
  std::uint32_t vertex = 0;
  std::uint32_t handle = 0;
};

// The mesh's Laplacian without the held vertices, and its factor. Where a vertex stands: `place` is a free vertex's row
// in the factor, and for held ones follows after all of the free.
struct HeldLaplacian {
  std::vector<HeldVertex> held;
  std::vector<std::uint32_t> place;
  std::size_t free = 0;
  SparseFactor factor;
};
// Throws InvalidInput if a vertex is held twice or a part of the surface nowhere.
HeldLaplacian hold(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                   std::span<const HeldVertex> held);

// Row v, column h: the share of handle h at vertex v. Rows sum to one, all are between 0 and 1.
using HandleShares = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
HandleShares harmonic_shares(const TriangleMesh& mesh, const std::vector<CornerWeights>& weights,
                             const HeldLaplacian& system, std::size_t handles);

}  // namespace rotunda::recon
