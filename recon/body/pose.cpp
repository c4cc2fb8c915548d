#include "recon/body/pose.h"

#include <algorithm>

namespace rotunda::recon {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;

Quaterniond mirrored_rotation(const Quaterniond& rotation) {
  return {rotation.w(), -rotation.x(), rotation.y(), -rotation.z()};
}

}  // namespace

Pose rest_pose() {
  Pose pose;
  pose.rotation.fill(Quaterniond::Identity());
  return pose;
}

JointTransforms joint_transforms(const Skeleton& skeleton, const Pose& pose) {
  JointTransforms world_from_joint;
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    Isometry3d local = Isometry3d::Identity();
    const auto parent = parent_of(body_joint(j));
    local.translation() = parent ? skeleton.offset[j] : pose.root;
    local.linear() = pose.rotation[j].toRotationMatrix();
    world_from_joint[j] = parent ? world_from_joint[index(*parent)] * local : local;
  }
  return world_from_joint;
}

std::array<Eigen::Vector3d, kBodyJoints> joint_positions(const Skeleton& skeleton, const Pose& pose) {
  const auto transforms = joint_transforms(skeleton, pose);
  std::array<Eigen::Vector3d, kBodyJoints> positions;
  std::transform(transforms.begin(), transforms.end(), positions.begin(),
                 [](const Isometry3d& world_from_joint) { return world_from_joint.translation(); });
  return positions;
}

Pose interpolate(const Pose& a, const Pose& b, double share) {
  Pose pose;
  pose.root = (1.0 - share) * a.root + share * b.root;
  for (std::size_t j = 0; j < kBodyJoints; ++j) pose.rotation[j] = a.rotation[j].slerp(share, b.rotation[j]);
  return pose;
}

Pose mirrored(const Pose& pose) {
  Pose mirror = pose;
  for (std::size_t j = 1; j < kBodyJoints; ++j)
    mirror.rotation[j] = mirrored_rotation(pose.rotation[index(mirrored(body_joint(j)))]);
  return mirror;
}

Pose within_limits(const Pose& pose) {
  Pose limited = pose;
  for (std::size_t j = 1; j < kBodyJoints; ++j) {
    const auto& range = range_of(body_joint(j));
    const auto coordinates = range_coordinates(range, pose.rotation[j]);
    limited.rotation[j] = rotation_at(range, coordinates.cwiseMax(range.low).cwiseMin(range.high));
  }
  return limited;
}

}  // namespace rotunda::recon
