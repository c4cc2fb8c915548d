#pragma once
// What a mouse points at: the first triangle of a surface on the ray through a pixel. Every triangle is tried: of three
// hundred thousand in some milliseconds. World frame, metres. The viewpoint's distortion must be none.
#include <optional>

#include "playback/viewpoint.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

struct SurfacePick {
  std::uint32_t triangle = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double depth = 0.0;  // along the eye's z
};

// Either face counts. Nothing where the ray misses, or meets the surface behind the eye.
std::optional<SurfacePick> pick(const recon::TriangleMesh& mesh, const Viewpoint& viewpoint,
                                const Eigen::Vector2d& pixel);

// Across a triangle, outwards, twice as long as its area.
Eigen::Vector3f outwards(const recon::TriangleMesh& mesh, std::uint32_t triangle);

// Where a place is seen, and its depth; nothing behind the eye.
std::optional<Eigen::Vector3d> seen_at(const Viewpoint& viewpoint, const Eigen::Vector3d& place);

}  // namespace rotunda::playback
