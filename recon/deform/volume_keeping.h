#pragma once
// Keeps the volume about each joint: the cone from the joint's centre over the surface about it, whose rims the rigid
// limbs carry along, has at rest a volume that bending takes some of. The surface is moved along its normals, most at
// the joint, not at all where it is held, until the volume is there again. Lanes as in lane_kernels.h.
#include <cstdint>
#include <span>
#include <vector>

namespace rotunda::recon {

struct ConeTriangle {
  std::uint32_t row[3];       // of the corners' positions
  std::uint32_t gradient[3];  // and of their gradients of volume
  std::uint32_t joint;
};
struct BulgeVertex {
  std::uint32_t row, gradient, joint;
  float scale;  // how far it goes with the joint's bulge, over its area at rest, 1 / m^2
};

// Volumes of the cones (added; joints x lane_count()) and their gradients (added; rows). `centres`: joints x 3 x lanes.
void add_cones(std::span<const ConeTriangle> triangles, const float* centres, const float* rows, float* volumes,
               float* gradients);

// Moves the surface by as much as makes up for `missing` (joints x lanes, m^3) to first order. `slopes`: room for
// joints x lanes.
void bulge(std::span<const BulgeVertex> vertices, std::size_t joints, const float* missing, const float* gradients,
           float* slopes, float* rows);

}  // namespace rotunda::recon
