#pragma once
// Fewer triangles, same topology: edge collapses that keep the link condition (OpenMesh), so a closed genus-0 surface
// stays one. Positions are kept; normals and colours are dropped (compute or sample them afterwards).
#include <cstddef>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Collapses to at most `triangles` by quadric error (Garland, Heckbert 1997), refusing what would flip a normal; stops
// short where no collapse is left. Throws InvalidInput if the mesh is not manifold.
void simplify(TriangleMesh& mesh, std::size_t triangles);

// Collapses edges shorter than `shortest` to their middle where no normal turns by more than 60 degrees: the slivers
// of Marching Cubes. Returns how many. Throws InvalidInput if the mesh is not manifold.
std::size_t collapse_slivers(TriangleMesh& mesh, double shortest);

}  // namespace rotunda::recon
