#pragma once
// A signed distance sampled on a cubic lattice with finer boxes in it, and the surface between inside and outside as a
// closed mesh: one vertex in each cell the surface passes, joined across the edges it crosses (dual contouring on an
// adaptive lattice: Ju, Losasso, Schaefer, Warren 2002; vertices as in Gibson's surface nets 1998). No cracks where
// fine meets coarse.
#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::simulator {

// Cells of a lattice, from inclusive to exclusive.
struct CellBox {
  std::array<int, 3> from{}, to{};
};

// The part of space that is cut `factor` times finer along each axis, metres. Grows to whole coarse cells.
struct FinerBox {
  Eigen::Vector3d low, high;
  int factor = 2;
};

struct GradedLatticeOptions {
  Eigen::Vector3d low, high;    // what is searched, metres
  double cell = 0.013;          // metres
  std::vector<FinerBox> finer;  // must not touch each other
};

// Negative inside, true to first order near the surface; asked from several threads.
using DistanceAt = std::function<double(const Eigen::Vector3d&)>;

// Positions and triangles, facing outwards. Where a cell would hold two sheets the body grows by less than a cell, so
// that the surface never touches itself within a lattice. Throws InvalidInput for an empty box.
recon::TriangleMesh contour(const DistanceAt& distance, const GradedLatticeOptions& options);

}  // namespace rotunda::simulator
