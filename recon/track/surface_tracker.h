#pragma once
// A key frame's surface carried from frame to frame onto surfaces that were reconstructed on their own. Each frame
// starts where every node would be if it went on as before (constant velocity), searches wide where that was fast, and
// keeps the key frame's shape at rest always. World frame, metres.
#include <vector>

#include "recon/track/surface_registration.h"

namespace rotunda::recon {

class SurfaceTracker {
 public:
  // Keeps a reference to the key frame's model.
  explicit SurfaceTracker(const SurfaceModel& model) : model_(&model), now_(model.still()), before_(now_) {}

  // The next frame's surface.
  void follow(const SurfaceTarget& target);
  // A frame without a surface: what was goes on.
  void skip();

  TriangleMesh carried() const { return model_->moved(now_); }

 private:
  std::vector<NodeMotion> predicted() const;

  const SurfaceModel* model_;
  std::vector<NodeMotion> now_, before_;
};

}  // namespace rotunda::recon
