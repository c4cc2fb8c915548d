#pragma once
// One closed skin of genus 0 from the live hull: its largest piece, cavities filled, handles cut where the solid is
// thinnest, as genus_cut.h, by simple points grown deepest first; over a dense box around the solid instead of the
// sparse grid, which takes a third of the time. World frame and units; no normals, no colours.
#include "recon/hull/sparse_grid.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Changes `grid` so that its inside (value > 0) is a topological ball, if it has any inside at all; returns how many
// samples that is. Throws InvalidInput if the box around what is inside has more than 2^27 samples.
std::size_t live_cut(SignedGrid& grid);

// The cut grid's surface; empty if nothing is inside. `margin` as marching_cubes() has it.
TriangleMesh live_skin(SignedGrid& grid, double margin);

}  // namespace rotunda::recon
