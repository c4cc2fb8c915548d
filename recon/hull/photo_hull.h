#pragma once
// Photo hull of one FrameSet by Generalized Voxel Coloring (Culbertson, Malzbender, Slabaugh 1999) with item buffers:
// cells on the hull's surface whose colour differs over exactly the views that see them are carved, visibility is
// rendered anew, and so on until none is carved. ALGORITHMS step 3. World frame and units.
// Pure; the same on any number of threads.
#include <opencv2/core.hpp>
#include <span>

#include "recon/hull/silhouette_view.h"
#include "recon/hull/sparse_grid.h"

namespace rotunda::recon {

struct PhotoHullOptions {
  double most_spread = 25.0;  // grey levels: root mean square, over views and channels, of the views' mean colours
  int least_views = 2;        // that must see a cell for its colour to be tested
  double rim_px = 1.5;        // pixels nearer to the outline mix with the backdrop and say nothing
  double deepest = 0.05;      // world units: so far in, a cell that two views do not agree on stays all the same
  int most_rounds = 100;
};

struct PhotoHullReport {
  int rounds = 0;
  std::size_t carved = 0;  // samples
};

// `grid`: the visual hull (visual_hull.h), of which the inside becomes that of the photo hull: carved samples are half
// a cell outside. `pictures`: RGB, one a view. Throws InvalidInput if the spans or a picture's size do not fit.
PhotoHullReport carve_photo_hull(SignedGrid& grid, std::span<const SilhouetteView> views,
                                 std::span<const cv::Mat> pictures, const PhotoHullOptions& options = {});

}  // namespace rotunda::recon
