#pragma once
// A mesh that follows handles (de Aguiar, Zayer, Theobalt, Magnor, Seidel 2007, section 4; ALGORITHMS step 13): the
// handles' quaternions spread as harmonic fields (harmonic_rotation.h), every triangle turned by the mean of its
// corners' (the fragmented mesh), and the tight mesh whose Laplacian is the fragmented one's in the least squares
// sense:
//     L X = U_reduced                                                                                            (2)
// L is factorised once. Past the paper, by default: held vertices are where their handle takes them, not only in the
// least squares sense (then both systems share one factor), and about every joint the surface is moved along its
// normals until it holds the volume it had at rest.
// Several frames are solved together (lane_kernels.h); a frame's result does not depend on which, nor on the threads.
#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "recon/deform/harmonic_rotation.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// posed = rotation * rest + translation. The rotation's sign counts: neighbours and successive frames must agree in it.
struct HandlePose {
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
  Eigen::Vector3f translation = Eigen::Vector3f::Zero();
};

// Where two handles meet: a point that both carry to the same place. Volume is kept about it.
struct HandleJoint {
  std::uint32_t a = 0, b = 0;
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  // at rest
};

struct PoissonDeformOptions {
  std::size_t handles = 0;
  bool hold_positions = true;                         // false: as the paper, only the first held vertex is pinned
  std::vector<HandleJoint> joints;                    // empty: volume is left to itself
  std::vector<std::array<std::uint32_t, 3>> bridges;  // triangles that tie pieces together but are no surface
};

// What the stages of a batch cost, CPU seconds, summed over batches.
struct DeformClock {
  double rotate_s = 0.0, solve_s = 0.0, volume_s = 0.0, store_s = 0.0;
};

class PoissonDeform {
 public:
  // Throws InvalidInput: what hold() refuses, handles out of range.
  PoissonDeform(const TriangleMesh& rest, std::span<const HeldVertex> held, const PoissonDeformOptions& options);
  ~PoissonDeform();
  PoissonDeform(PoissonDeform&&) noexcept;

  std::size_t vertices() const;
  const HandleShares& shares() const;  // of the handles at every vertex: skinning weights, too
  // `poses`: frames x handles. `positions`: frames x vertices, filled. Frames are spread over threads.
  void deform(std::span<const HandlePose> poses, std::span<Eigen::Vector3f> positions);
  DeformClock clock() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// Chooses of q and -q what is nearer to the parent's and, while that is not against it, to the frame before, so that
// fields between handles run the short way and do not jump. `parent`: of every handle, an earlier one or -1.
// `poses`: frames x handles.
void agree_in_sign(std::span<HandlePose> poses, std::span<const int> parent);

}  // namespace rotunda::recon
