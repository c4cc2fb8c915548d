#pragma once
// The visual hull at live quality: visual_hull.h for a few milliseconds. Quarters of blocks that one view empties, or
// that a view wholly holds, are not asked sample by sample; distances are to first order without the lens's slope. What
// fewer than two views see is outside. World frame and units. The same on any number of threads.
#include <Eigen/Geometry>
#include <span>

#include "recon/hull/sparse_grid.h"
#include "recon/live/live_silhouette.h"

namespace rotunda::recon {

// Exact within a cell of the surface, to first order. Throws InvalidInput for an empty volume, or if the surface needs
// more than SignedGrid::kMaxBlocks.
SignedGrid live_hull(std::span<const LiveSilhouette> views, const Eigen::AlignedBox3d& bounds, double cell_size);

}  // namespace rotunda::recon
