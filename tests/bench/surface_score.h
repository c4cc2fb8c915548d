#pragma once
// How near a surface comes to the true one: symmetric distance and completeness, millimetres; and how its shape agrees,
// whatever the distance: steps and dents turn the normals.
#include <span>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"
#include "recon/mesh/triangle_mesh.h"
#include "tests/support/surface_distance.h"

namespace rotunda::bench {

struct SurfaceScore {
  double mean = 0.0, p95 = 0.0;   // of both ways together, as many points of area each
  double within_10mm = 0.0;       // share of the truth that the surface comes so near
  double seen_within_10mm = 0.0;  // the same of what of the truth a camera has before it; 0 if none were given
  double normals_off_deg = 0.0;   // mean angle between its normals and those of the truth nearest to them
};

// One truth for many surfaces. Lends the mesh.
class SurfaceJudge {
 public:
  explicit SurfaceJudge(const recon::TriangleMesh& truth, std::span<const capture::CameraModel> cameras = {});
  SurfaceScore score(const recon::TriangleMesh& surface) const;
  // Share of the truth that some camera has before it: the rest (inside of coats and skirts, soles) nobody can know.
  double seen_share() const;

 private:
  double normals_off(const recon::TriangleMesh& surface) const;

  const recon::TriangleMesh& truth_;
  tests::DistanceTree tree_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<char> seen_;  // of the points: 1 if some camera has it before it
};

// Overlap (IoU) of the surface's outline with the mattes, mean over the cameras.
double outline_overlap(const recon::TriangleMesh& surface, const std::vector<capture::CameraModel>& cameras,
                       const std::vector<capture::Matte>& mattes);

}  // namespace rotunda::bench
