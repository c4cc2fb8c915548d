#pragma once
// How much each joint carries each vertex of a body, and the body carried along: dual quaternion skinning (Kavan,
// Collins, Zara, O'Sullivan, "Geometric skinning with approximate dual quaternion blending", 2008), which keeps the
// thickness of a limb that bends or twists.
#include <array>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

struct SkinWeights {
  std::array<std::uint8_t, 4> joint{};
  std::array<float, 4> weight{};  // sum to 1, largest first
};

// Each vertex starts as wholly its nearest part's; the weights then spread over the surface by diffusion, so that a
// joint bends over about +-5 cm and nothing leaks through air from limb to limb.
std::vector<SkinWeights> skin_weights(const recon::TriangleMesh& mesh, const BodyShape& shape);

// The vertices of `bind` carried along by the joints; triangles and colours as they were, normals anew.
recon::TriangleMesh skinned(const recon::TriangleMesh& bind, const std::vector<SkinWeights>& weights,
                            const JointTransforms& world_from_bind);

}  // namespace rotunda::simulator
