#pragma once
// A Pose of a Skeleton: where the pelvis is and how every joint is turned. World, metres.
#include <Eigen/Geometry>
#include <array>

#include "recon/body/skeleton.h"

namespace rotunda::recon {

struct Pose {
  Eigen::Vector3d root = Eigen::Vector3d::Zero();        // the pelvis joint in world
  std::array<Eigen::Quaterniond, kBodyJoints> rotation;  // of a joint's frame in its parent's (pelvis: in world), unit
};
Pose rest_pose();  // all identity, at the origin: the T-pose

// world_from_joint: carries a point given from the joint at rest along with that joint.
using JointTransforms = std::array<Eigen::Isometry3d, kBodyJoints>;
JointTransforms joint_transforms(const Skeleton& skeleton, const Pose& pose);
std::array<Eigen::Vector3d, kBodyJoints> joint_positions(const Skeleton& skeleton, const Pose& pose);  // world

Pose interpolate(const Pose& a, const Pose& b, double share);  // 0: a, 1: b; rotations the short way (slerp)
Pose mirrored(const Pose& pose);  // as in a mirror standing in the person's own plane of symmetry; the pelvis stays
Pose within_limits(const Pose& pose);  // every joint carried into its range

}  // namespace rotunda::recon
