#pragma once
// The last step of carrying a surface: off the graph's shape onto the frame's own surface, along the normals alone, so
// that vertices do not slide. Offsets are evened out over the surface; outwards they count less, because a hull is
// never smaller than the body. Triangles that fold are evened out with what is around them.
#include <cstddef>

#include "recon/track/surface_target.h"

namespace rotunda::recon {

struct SettledSurface {
  TriangleMesh mesh;              // with normals
  double residual_mean_mm = 0.0;  // of the vertices, settled, to the frame's surface, by area
  double residual_p95_mm = 0.0;
  double uncovered = 0.0;  // share of the frame's area that lies farther than 50 mm from the settled surface
  std::size_t folds = 0;   // triangles that still face against the surface they lie on
};

struct SettleOptions {
  double outwards = 0.3;  // of the way
  int rounds = 2;         // 15 mm each at most
};

// The surface as it is, measured against the frame's own; with normals. `folds` is not looked for.
SettledSurface measured(TriangleMesh mesh, const SurfaceTarget& target);

// carried: with normals.
SettledSurface settle(const TriangleMesh& carried, const SurfaceTarget& target, const SettleOptions& options = {});

}  // namespace rotunda::recon
