#pragma once
// Geometry image (Gu, Gortler, Hoppe 2002): a closed surface sampled on the closed octahedral lattice of
// (2^level + 1)^2 samples, unfolded to a square. One pole at the square's centre, the other at its four corners; on
// each border line sample i equals sample N-1-i. Levels nest by stride 2. World frame, metres. ALGORITHMS step 6.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct GeometryImage {
  int level = 8;                           // n; 2^n + 1 samples a side
  std::vector<Eigen::Vector3f> positions;  // row by row
  std::vector<Eigen::Vector3f> normals;    // unit
  int colour_level = 8;                    // m >= level
  std::vector<Colour> colours;             // (2^m + 1)^2
  std::vector<std::uint8_t> coverage;      // (2^m + 1)^2: 255 seen by a camera, 0 filled in

  int side() const { return (1 << level) + 1; }
  int colour_side() const { return (1 << colour_level) + 1; }
};

}  // namespace rotunda::recon
