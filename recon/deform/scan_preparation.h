#pragma once
// A scan as it comes (metres or not, lying, upside down, in pieces) made ready to be animated: in metres, standing
// upright on z = 0 with z up, facing +x. Each change is told.
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct PreparedScan {
  TriangleMesh mesh;                                  // with normals; colours where the scan has them
  std::vector<std::uint32_t> from_triangle;           // of each triangle: its number in the scan's file
  std::vector<std::array<std::uint32_t, 3>> bridges;  // between pieces that lie apart; not part of the surface
  Eigen::Affine3d prepared_from_scan = Eigen::Affine3d::Identity();  // a rotation, a shift, and the unit's scale
  double height = 0.0;                                               // metres
  std::vector<std::string> notes;                                    // what was changed, what is missing
};

// Vertices in the same place become one; triangles without area and pieces smaller than a hundredth of the body go;
// larger ones that a scanner's gaps cut off are tied on by `bridges`.
// Throws InvalidInput for a scan that has no triangles, holds numbers that are not finite, has large pieces far from
// the body, or shows nobody standing with a head, two legs and arms away from the body.
PreparedScan prepare_scan(const TriangleMesh& scan);

}  // namespace rotunda::recon
