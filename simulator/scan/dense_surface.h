#pragma once
// A surface cut into more and smaller triangles, with its texture's colours at the vertices. Edges are halved, the
// longest first (Rivara 1984), so that triangles become even and stay well shaped; every vertex lies on the surface
// given.
#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/surface_texture.h"

namespace rotunda::simulator {

// With `triangles` triangles, one more where each cut gives two; fewer than the surface has: the same by edge collapses
// among its vertices (recon/mesh/simplify.h). Each manifold piece keeps its topology; where edges have more than two
// triangles, or fans meet in a vertex, the surface is taken apart. Throws InvalidInput for a surface without triangles
// or a texture of another one.
recon::TriangleMesh dense_surface(const recon::TriangleMesh& surface, const SurfaceTexture& texture,
                                  std::size_t triangles);

}  // namespace rotunda::simulator
