#pragma once
// Which way up somebody stands in a scan, and which way they face, told from the shape alone: two legs below, one small
// head above, arms to both sides, toes before the ankles. Private to scan_preparation.
#include <Eigen/Geometry>
#include <string>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct UprightStance {
  Eigen::Isometry3d upright_from_scan;  // z up, x forward, the soles on z = 0 about the origin; the scan's unit
  double height = 0.0;                  // the scan's unit
  std::string told;                     // what it was, if not upright: "lies along x"
};

// Throws InvalidInput if no direction of the six axes shows a person standing.
UprightStance find_stance(const TriangleMesh& mesh);

}  // namespace rotunda::recon
