#pragma once
// Smoothing that keeps volume and detail: Taubin's lambda|mu low-pass filter (1995) on the umbrella Laplacian, followed
// by an exact correction of the volume along the normals. Takes off the staircase of a grid without shrinking limbs.
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct SmoothingOptions {
  int rounds = 10;
  double lambda = 0.5;     // of the shrinking half-step
  double pass_band = 0.1;  // spatial frequencies (eigenvalues of the umbrella, 0 to 2) below it are kept
};

// Moves positions only; a mesh without triangles is left as it is.
void smooth(TriangleMesh& mesh, const SmoothingOptions& options = {});

}  // namespace rotunda::recon
