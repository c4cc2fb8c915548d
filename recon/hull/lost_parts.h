#pragma once
// What a key lost in one or two views is put back by the others. Most places that one view alone denies are air that no
// other silhouette shows; where it is wrong, the hull loses a part of the body, and then the other views' silhouettes
// show something that no hull stands behind (all silhouettes being right, a hull's outline is the silhouette in every
// view: Laurentini 1994). A place is lost if at most two views deny it, all others that see it hold it, and in more
// than twice as many of these as deny it the silhouette there is unexplained. World frame and the calibration's unit.
// Pure; the same on any number of threads.
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "recon/hull/silhouette_view.h"

namespace rotunda::recon {

struct LostPartsOptions {
  Eigen::AlignedBox3d bounds;  // the volume to search
  double cube_size = 0.020;    // world units: parts thinner than this are not looked for
};

struct LostParts {
  std::vector<SilhouetteView> views;  // their silhouettes joined with what they had lost
  std::vector<double> share;          // of each view's silhouette as it was: how much was put back; 0: nothing
};

// Fewer than five views change nothing: three must bear witness against one.
LostParts put_back_lost_parts(std::span<const SilhouetteView> views, const LostPartsOptions& options);

}  // namespace rotunda::recon
