#pragma once
// The zero surface of a signed grid (Lorensen, Cline 1987), closed and outward-facing, vertices on the cells' edges at
// the linear zero. The table is derived, not listed: on a face with two opposite inside corners the insides are joined,
// and two inside corners opposite through the cube are joined by a tube. So the solid has exactly the topology of the
// inside samples under 26-neighbourhood, its complement that of the outside samples under 6-neighbourhood: what
// genus_cut.h keeps simple stays simple here. What the grid does not store is outside.
#include "recon/hull/sparse_grid.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// World frame and units; positions and triangles only. Every edge has two triangles for any field.
// Vertices keep `margin` cells off the samples, where several crossings would meet in one point: no edge is shorter
// than sqrt(2) of it.
TriangleMesh marching_cubes(const SignedGrid& grid, double margin = 0.01);

}  // namespace rotunda::recon
