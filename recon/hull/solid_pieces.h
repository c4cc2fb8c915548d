#pragma once
// A solid of one piece made of several: people and props that touch nobody are pieces (26-connected) of their own. One
// is kept, others become outside, or are tied to it by a thread of one sample's thickness, so that the surface, which
// is one closed skin, holds them all.
#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "recon/hull/sparse_grid.h"

namespace rotunda::recon {

struct PieceRule {
  std::optional<Eigen::Vector2d>
      performer_at;          // x and y in world units: the piece nearest to it is kept; none: the largest
  double tied_volume = 0.0;  // world units cubed: other pieces of at least this are tied; 0: none
};

struct PieceReport {
  std::size_t pieces = 0;          // of the solid before
  std::size_t dropped_voxels = 0;  // of all that are neither kept nor tied
  std::size_t tied = 0;            // pieces
};

// Changes `grid`: its inside (value > 0) is one piece afterwards, if it has any. Blocks are added where threads run.
PieceReport settle_pieces(SignedGrid& grid, const PieceRule& rule = {});

}  // namespace rotunda::recon
