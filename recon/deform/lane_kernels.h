#pragma once
// The inner loops of the deformation. Several frames are deformed together, a lane of the vector registers each, so
// that factor, weights and triangles are read once for all of them. A row holds a vertex: x of every lane, then y,
// then z. Compiled for each kind of vector unit there is and chosen when the program runs (Highway); lanes never mix,
// so a frame's result does not depend on its neighbours.
#include <cstdint>
#include <span>
#include <vector>

#include "recon/deform/sparse_factor.h"

namespace rotunda::recon {

std::size_t lane_count();  // frames in a batch on this machine: 4, 8 or 16

// Solves L L^T x = b in place: rows of 3 x lane_count() floats in the factor's order, aligned to 64 bytes.
void solve_lanes(const SparseFactor& factor, float* rows);

// A triangle as the fragmented mesh needs it: the rows of its corners; its share of the Laplacian of the first two
// corners at rest (that of the third is minus their sum); whose rotations it takes, as a range of HandleShare.
struct FragmentTriangle {
  std::uint32_t row[3];
  float first[3], second[3];
  std::uint32_t shares_begin, shares_end;
};
struct HandleShare {
  std::uint32_t handle;
  float weight;
};

// Per triangle: blends the handles' quaternions (w x y z, lane_count() each), turns its shares of the Laplacian, adds
// them to the rows (U_reduced of eq. (2)).
void add_fragments(std::span<const FragmentTriangle> triangles, std::span<const HandleShare> shares,
                   const float* quaternions, float* rows);

// rows[row] = where the handle takes a vertex; `transforms`: of every handle a 3 x 4 matrix row by row, lane_count()
// each.
struct HeldPlace {
  std::uint32_t row, handle;
  float rest[3];
};
void place_held(std::span<const HeldPlace> held, const float* transforms, float* rows);

// rows[to] += weight * rows[from].
struct RowLink {
  std::uint32_t to, from;
  float weight;
};
void add_links(std::span<const RowLink> links, float* rows);

}  // namespace rotunda::recon
