#pragma once
// The surface of a BodyShape as triangles: contoured on a lattice that is finer about head, hands and feet, then drawn
// onto the exact surface. Person frame, metres; triangles face outwards.
#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

// Closed, one piece, without a handle; throws InvalidInput if the build is so odd that it is not.
// `coarseness` widens the lattice: 1 gives about 50 000 triangles.
recon::TriangleMesh body_mesh(const BodyShape& shape, const Skeleton& skeleton, double coarseness = 1.0);

// Corners joined to each vertex by an edge.
std::vector<std::vector<std::uint32_t>> neighbours_of(const recon::TriangleMesh& mesh);

}  // namespace rotunda::simulator
