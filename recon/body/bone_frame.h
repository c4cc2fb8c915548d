#pragma once
// Frames and turns of bones, by which a motion is carried from one skeleton to another: for every reader of BVH.
#include <Eigen/Geometry>

namespace rotunda::recon {

// A right-handed orthonormal frame, as columns: along `first`, towards `second`, across both. Neither may be zero nor
// may they be parallel.
inline Eigen::Matrix3d frame_of(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  Eigen::Matrix3d frame;
  frame.col(0) = first.normalized();
  frame.col(1) = (second - frame.col(0) * frame.col(0).dot(second)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

// The rotation by the smallest angle that brings one direction to the other; none for a bone without length (any unit).
inline Eigen::Matrix3d shortest_turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  if (from.norm() < 1e-9 || to.norm() < 1e-9) return Eigen::Matrix3d::Identity();
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace rotunda::recon
