#pragma once
// How far a surface is from another: residuals of a fit, to be looked at. Metres.
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Of each of `from`'s vertices to the nearest place of `onto` that faces the same way; `reach` where there is none
// nearer. Both have normals. Throws InvalidInput if they have not. Equal on any number of threads.
std::vector<float> surface_distances(const TriangleMesh& from, const TriangleMesh& onto, double reach);

}  // namespace rotunda::recon
