#pragma once
// Visual hull of one FrameSet: the largest solid that agrees with every silhouette (Laurentini 1994), carved coarse to
// fine (Szeliski 1993) as a signed field instead of 0/1 voxels. World frame and units (metres). ALGORITHMS step 3.
// The field is the least signed distance to the silhouettes' cones over the views that see a point. Outside of a view's
// picture is unknown to it, not empty; what fewer than `min_views` see is outside.
// Pure: no files, no log; the same result on any number of threads.
#include <Eigen/Geometry>
#include <span>

#include "recon/hull/silhouette_view.h"
#include "recon/hull/sparse_grid.h"

namespace rotunda::recon {

struct VisualHullOptions {
  Eigen::AlignedBox3d bounds;  // searched volume, world
  double cell_size = 0.010;    // edge of the finest cell, world units
  int min_views = 2;           // that must see a point for it to be inside
  int tolerate_misses = 0;     // so many views may call a point outside (a lost arm in one matte) and it stays inside
};

// Field values are exact within three cells of the surface and inside; farther out only their sign is.
// Throws InvalidInput for an empty volume, for fewer than two views, or if the surface needs more than
// SignedGrid::kMaxBlocks.
SignedGrid visual_hull(std::span<const SilhouetteView> views, const VisualHullOptions& options);
SignedGrid visual_hull(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                       const VisualHullOptions& options);

// What each view alone would have cut off: the share of the grid's inside, 0 to 1, that lies farther outside of its
// cone than a cell. More than nothing only where misses were tolerated.
std::vector<double> denied_shares(std::span<const SilhouetteView> views, const SignedGrid& grid);

// The search alone: cubes of edge `cell_size * 2^k` that no view empties, k levels deep; for looking for the volume.
std::vector<Eigen::Vector3i> occupied_cubes(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& bounds,
                                            double cube_size, const VisualHullOptions& options);

}  // namespace rotunda::recon
