#pragma once
// Spherical matching (Starck, Miller, Hilton 2005, section 4; ALGORITHMS.md step 8): the lattice S of one geometry
// image is deformed over the sphere of another, S', until equal places of the two surfaces lie upon each other. Eq. (4)
// to (10) and the annealing are the paper's: first the rotation of the sphere that costs least, then level by level of
// the subdivided octahedron the fuzzy correspondence W and, for that W, a step of every sample, at a temperature T that
// is the level's edge length. Samples never leave the kernel of their 1-ring: the map is a bijection at every moment.
// Positions in metres relative to the surface's own middle; both surfaces stand alike (heading is kept).
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "recon/sphere/geometry_image.h"

namespace rotunda::recon {

// The constants are the paper's.
struct MatchingOptions {
  double position_sigma = 0.05;   // of a right match, metres
  double normal_sigma = 0.5;      // of the difference of unit normals: about 30 degrees
  double colour_sigma = 50.0;     // of 255
  double regularity = 0.75;       // lambda of eq. (4)
  double smallest_update = 1e-4;  // on the unit sphere: a level ends when no sample moves farther
  int most_updates = 40;          // of a level; the paper has no bound, and gains .4 mm by two hundred
  bool one_by_one = false;  // samples move in their order, as the paper has them; else sets that are no neighbours
};

struct SphereMatch {
  struct Level {
    int level = 0;
    int updates = 0;  // of all samples
    double largest_update = 0.0;
  };
  std::vector<Eigen::Vector3d> directions;  // of each sample of S on the sphere of S', raster order
  Eigen::Matrix3d rotation;                 // that it began with
  std::vector<Level> levels;                // from the octahedron on
  std::size_t folds = 0;                    // spherical triangles that are not counter-clockwise, exactly; always 0
};

// Both with positions, normals and colours, of one level. The same result on any number of threads. Throws InvalidInput
// where levels differ or something is missing.
SphereMatch match_on_sphere(const GeometryImage& from, const GeometryImage& to, const MatchingOptions& options = {});

// `from` read at the samples of what it was matched to: texel by texel the same places of the surface.
GeometryImage matched_image(const GeometryImage& from, const SphereMatch& match);

}  // namespace rotunda::recon
