#pragma once
// The surface of a BodyShape as triangles: dual vertices on a graded grid (Gibson, "Constrained elastic surface nets",
// 1998), drawn onto the exact surface. Finer over head and hands. Person frame, metres; triangles face outwards.
#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

// Closed, one piece, without a handle; throws InvalidInput if the build is so odd that it is not.
// `coarseness` widens the grid: 1 gives about 50 000 triangles.
recon::TriangleMesh body_mesh(const BodyShape& shape, const Skeleton& skeleton, double coarseness = 1.0);

// Corners joined to each vertex by an edge.
std::vector<std::vector<std::uint32_t>> neighbours_of(const recon::TriangleMesh& mesh);

}  // namespace rotunda::simulator
