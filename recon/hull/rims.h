#pragma once
// Rims: the places where the silhouettes' cones touch the body, all that silhouettes really know of it. The ray through
// a point of one view's outline, cut by all other silhouettes (Matusik et al. 2000), leaves stretches of the hull;
// where only one is left the body touches the ray somewhere along it, and its middle is the best guess, the better the
// shorter it is. Rays with several stretches tell nothing: any of them may be empty.
// World frame and units. Pure; the same on any number of threads.
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "recon/hull/silhouette_view.h"

namespace rotunda::recon {

struct Rim {
  Eigen::Vector3f point;   // the stretch's middle
  Eigen::Vector3f normal;  // of the silhouette's cone there, outward, unit
  float length = 0.0F;     // of the stretch
  float pixel = 0.0F;      // world units a pixel of that view's, there
};

struct RimOptions {
  Eigen::AlignedBox3d bounds;  // where the body is
  double shortest = 0.003;     // world units: what noise leaves of a ray beside the body
  double longest = 0.120;      // says little of where the body is
  int stride = 1;              // every so manieth outline point
};

// `metre`: one, in world units, or what is to a small or huge body as a metre is to a person.
RimOptions rim_options(const Eigen::AlignedBox3d& bounds, double metre, int stride);

// In the order of views and, within, of outline points from top to bottom.
std::vector<Rim> find_rims(std::span<const SilhouetteView> views, const RimOptions& options);

}  // namespace rotunda::recon
