#pragma once
// What the pictures tell of a surface that is nearly right: for every vertex the offset along its normal at which the
// cameras that see it best agree (photo_agreement.h), as its neighbours and it have it together, the less trusted the
// less it stands out from others; held to the prior (an offset of nothing, the looser the farther from a rim), made
// smooth over the surface by quadratic relaxation (Newcombe et al. 2011: search each vertex's offsets near the smooth
// field, smooth the field near what was found, ever nearer), and nowhere steep. World frame and units. Pure; the same
// on any number of threads.
#include <span>
#include <vector>

#include "recon/hull/photo_agreement.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct PhotoFitOptions {
  bool thinned = false;  // ask no two neighbours: what lies between has it from them
  double reach = 0.016;  // world units either way
  int steps = 8;         // offsets tried either way
  PhotoAgreementOptions agreement;
  int even_rounds = 2;            // agreements are means over neighbours, so many times
  double rival_distance = 0.010;  // world units: of two offsets that are two, not one
  double sure_margin = 0.05;      // of the best correlation above its rivals: less tells less
  double prior_sigma = 0.008;     // of the surface beside a rim, world units
  double prior_slope = 0.50;      // of that standard deviation by the distance to the nearest rim
  double farthest_sigmas = 1.5;   // of the prior: what lies beyond is not believed, however well pictures agree
  double least_reach = 0.0;       // world units: of the prior, so far; where it reaches less far pictures are not asked
  double photo_weight = 32.0;     // of a correlation that falls by one, against one sigma squared of the prior, halved
  double smoothness = 2.0;        // of a difference of one step between neighbours
  double steepest = 1.0;          // of offsets over the surface
};

// One offset a vertex along its normal. `rim_distance`: one a vertex (rim_fit.h).
std::vector<float> photo_offsets(const TriangleMesh& mesh, std::span<const float> rim_distance,
                                 std::span<const PhotoView> views, const PhotoFitOptions& options);

}  // namespace rotunda::recon
