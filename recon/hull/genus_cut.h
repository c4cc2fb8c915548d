#pragma once
// Cuts a solid to genus 0: one piece (solid_pieces.h), cavities filled, handles cut where the solid is thinnest. The
// solid is grown anew from its deepest sample, deepest first, taking only simple points (Bertrand, Malandain 1994) for
// 26-connected solid and 6-connected outside, which is what marching_cubes.h extracts: fronts that meet around a hole
// leave a one-sample cut at the contact. Samples that are not cut or filled keep their values.
#include <cstddef>

#include "recon/hull/solid_pieces.h"

namespace rotunda::recon {

struct GenusCutReport {
  PieceReport pieces;
  std::size_t filled_voxels = 0;  // of cavities
  std::size_t cut_voxels = 0;     // left out to cut handles
  std::size_t solid_voxels = 0;   // after
};

// Changes `grid` so that its inside (value > 0) is a topological ball, if it has any inside at all.
GenusCutReport cut_to_genus_zero(SignedGrid& grid, const PieceRule& rule = {});

// Whether adding or removing a sample keeps topology, given which of its 26 neighbours are inside: bit
// (dx + 1) + 3 (dy + 1) + 9 (dz + 1), bit 13 (itself) ignored.
bool is_simple(std::uint32_t inside_neighbours);

}  // namespace rotunda::recon
