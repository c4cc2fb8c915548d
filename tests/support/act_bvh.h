#pragma once
// A simulated person's act as others write motions down: BVH, centimetres, y up, the bind pose (an A-pose) for zero.
#include <numbers>

#include "recon/body/bvh.h"
#include "simulator/people/act.h"

namespace rotunda::tests {

inline recon::BvhMotion act_bvh(const simulator::Skeleton& skeleton, const simulator::Motion& motion) {
  using simulator::index;
  Eigen::Matrix3d file_from_world;  // x forward, y left, z up becomes z forward, x left, y up
  file_from_world << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  recon::BvhMotion bvh;
  std::array<int, simulator::kJoints> place;
  std::vector<std::size_t> ours;
  for (std::size_t j = 0; j < simulator::kJoints; ++j) {
    const auto name = to_string(static_cast<simulator::Joint>(j));
    place[j] = -1;
    if (name.find("1_") != std::string_view::npos || name.find("2_") != std::string_view::npos) continue;  // fingers
    const auto parent = index(parent_of(static_cast<simulator::Joint>(j)));
    recon::BvhJoint joint;
    joint.name = name;
    joint.parent = j == 0 ? -1 : place[parent];
    if (j > 0) joint.offset = 100.0 * file_from_world * (skeleton.joint[j] - skeleton.joint[parent]);
    if (j == 0)
      joint.channels = {recon::BvhChannel::x_position, recon::BvhChannel::y_position, recon::BvhChannel::z_position};
    for (const auto channel :
         {recon::BvhChannel::z_rotation, recon::BvhChannel::x_rotation, recon::BvhChannel::y_rotation})
      joint.channels.push_back(channel);
    place[j] = static_cast<int>(bvh.joints.size());
    bvh.joints.push_back(joint);
    ours.push_back(j);
  }
  bvh.frame_time = simulator::kActStep;
  bvh.frames = static_cast<std::size_t>(motion.frames);
  for (int f = 0; f < motion.frames; ++f) {
    const auto pose = motion.pose_at(f * simulator::kActStep);
    for (const auto j : ours) {
      const Eigen::Vector3d root = 100.0 * file_from_world * pose.pelvis;
      if (j == 0) bvh.values.insert(bvh.values.end(), root.begin(), root.end());
      const Eigen::Matrix3d turn = file_from_world * pose.rotation[j].toRotationMatrix() * file_from_world.transpose();
      const Eigen::Vector3d angles = turn.eulerAngles(2, 0, 1) * 180.0 / std::numbers::pi;
      bvh.values.insert(bvh.values.end(), angles.begin(), angles.end());
    }
  }
  return bvh;
}

}  // namespace rotunda::tests
