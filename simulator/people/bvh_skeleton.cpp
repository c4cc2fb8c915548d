#include "simulator/people/bvh_skeleton.h"

#include "recon/body/bvh_joints.h"

namespace rotunda::simulator {
namespace {

// Fingers aside, both skeletons call their joints alike.
int counterpart(const recon::BvhJoints& found, Joint ours) {
  for (std::size_t j = 0; j < recon::kBodyJoints; ++j)
    if (recon::to_string(recon::body_joint(j)) == to_string(ours)) return found.joint[j];
  if (ours == Joint::toes_left) return found.toes[0];
  if (ours == Joint::toes_right) return found.toes[1];
  return -1;
}

}  // namespace

BvhSkeleton find_skeleton(const recon::BvhMotion& bvh, const std::string& name) {
  const auto found = recon::find_joints(bvh, name);
  BvhSkeleton skeleton;
  for (std::size_t j = 0; j < kJoints; ++j) skeleton.joint[j] = counterpart(found, static_cast<Joint>(j));
  skeleton.world_from_file = found.world_from_file;
  skeleton.zero_pose_stands = found.zero_pose_stands;
  skeleton.leg = found.leg;
  skeleton.notes = found.notes;
  return skeleton;
}

}  // namespace rotunda::simulator
