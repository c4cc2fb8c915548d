#pragma once
// Where a skeleton says that a surface is: the nodes of its deformation graph follow the bones beneath them. A node
// follows each joint as much as the surface it moves lies on that joint's segment of the body's template, posed as the
// surface is at rest; rotations are blended as quaternions, places linearly (Magnenat-Thalmann et al. 1988). A start
// for registration in any pose, not a surface: skin at joints is left to it. World frame, metres.
#include <array>
#include <vector>

#include "recon/body/body_template.h"
#include "recon/track/surface_registration.h"

namespace rotunda::recon {

class SkinnedPrior {
 public:
  // Keeps a reference to the model. at_rest: of `body` in the model's own frame.
  SkinnedPrior(const SurfaceModel& model, const BodyTemplate& body, const Pose& at_rest);

  // The nodes as a pose has them; `skeleton`: of the same person, as this or another take measured it.
  std::vector<NodeMotion> posed(const Skeleton& skeleton, const Pose& pose) const;

  // Of every node, one a joint; sum 1.
  using Weights = std::array<double, kBodyJoints>;
  const std::vector<Weights>& weights() const { return weights_; }

 private:
  const SurfaceModel& model_;
  JointTransforms rest_from_joint_inverse_;
  std::vector<Weights> weights_;
};

}  // namespace rotunda::recon
