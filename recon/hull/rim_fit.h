#pragma once
// From the hull's surface to the body's: between rims (rims.h) a hull lies outside of the body, the farther from the
// nearest rim the more. The surface is first moved inwards by a law of that distance, then settled as a screened
// membrane that rims hold, and never leaves the hull. World frame and units.
#include <span>

#include "recon/hull/rims.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// How far inside of the hull's surface the body lies, by distance s to the nearest rim: offset_px pixels at the body,
// and slope * min(s, farthest).
struct RimLaw {
  double offset_px = 0.0;
  double slope = 0.20;
  double farthest = 0.05;  // world units
};

struct RimFitOptions {
  RimLaw law;
  double cell_size = 0.010;       // of the grid the mesh was made on: rims reach so far
  double membrane_length = 0.08;  // world units over which the membrane evens out
  double pin_weight = 2.0;
  double trusted_length = 0.030;  // of a rim's stretch: a longer one counts less
  int stride = 1;                 // one rim stands for so many (RimOptions::stride)
  int rounds = 30;
};

// `metre` as rims.h has it.
RimFitOptions rim_fit_options(double cell_size, double metre, int stride);

// Distance of every vertex to the nearest rim, over the surface, at most `farthest`.
std::vector<float> rim_distances(const TriangleMesh& mesh, std::span<const Rim> rims, double cell_size,
                                 double farthest);

// Moves positions; the mesh is closed and has normals. Same triangles.
void fit_to_rims(TriangleMesh& mesh, std::span<const Rim> rims, const RimFitOptions& options);

// Brings a surface that was fitted, then changed, back to the rims: the membrane is then of how far it moves, so that
// what was found between rims stays. `hull`: the mesh as it was before it was fitted, which it does not leave.
void pin_to_rims(TriangleMesh& mesh, const TriangleMesh& hull, std::span<const Rim> rims, const RimFitOptions& options);

}  // namespace rotunda::recon
