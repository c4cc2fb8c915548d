#pragma once
// A key frame's shape made better by what other frames say of it. A visual hull is never smaller than the body; what
// one frame's hull adds another's does not, so that carried to one pose the body lies in what all of them share
// (Cheung, Baker, Kanade 2003, visual hull across time). For each vertex: how far surfaces lie beyond it along its
// normal, a low quantile of that over the frames, evened out over the surface.
#include <cstddef>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/track/surface_target.h"

namespace rotunda::recon {

class RestShape {
 public:
  // With normals.
  explicit RestShape(const TriangleMesh& key) : key_(key) {}

  // The key carried to a frame, and that frame's surface.
  void add(const TriangleMesh& carried, const SurfaceTarget& target);

  // The key with its vertices moved along their normals; as it was if fewer than kFewest frames were added.
  TriangleMesh refined() const;

  static constexpr std::size_t kFewest = 4;

 private:
  TriangleMesh key_;
  std::vector<std::vector<float>> offsets_;  // a frame each; metres, NaN: nothing near
};

}  // namespace rotunda::recon
