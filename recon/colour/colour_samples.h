#pragma once
// What a rig's cameras make of the same surface points: samples from which capture/calibration/colour_match.h finds how
// their colours differ. World frame and units; pure.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration/colour_match.h"
#include "recon/frame_reconstruction.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct ColourSampleOptions {
  std::size_t points = 1500;     // of the surface, spread over its vertices
  double least_cosine = 0.5;     // 60 degrees: flatter views show gloss
  double least_inside_px = 6;    // from the outline, where spill and the backdrop are
  int half_window = 2;           // pixels: a colour is the mean of (2 h + 1)^2
  double most_variation = 0.15;  // standard deviation over that window, relative to its mean: edges of a pattern are
                                 // not the same place in every view
};

// Colours of the surface's points in the views that see them. Cameras are numbered by `names`, places from
// `first_place` on by vertex. Points that fewer than two views see give none. Throws InvalidInput for a view that is
// not in `names`.
std::vector<capture::ColourSample> colour_samples(const TriangleMesh& surface, const FrameViews& views,
                                                  std::span<const std::string> names, std::size_t first_place,
                                                  const ColourSampleOptions& options = {});

}  // namespace rotunda::recon
