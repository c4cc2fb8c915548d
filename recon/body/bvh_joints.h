#pragma once
// Which joints of a BVH file are ours, and how the file's world lies in ours. Used by body_motion and the simulated
// people.
#include <array>
#include <string>
#include <vector>

#include "recon/body/bvh.h"
#include "recon/body/skeleton.h"

namespace rotunda::recon {

struct BvhJoints {
  std::array<int, kBodyJoints> joint;  // of the file, for each of ours; -1: none
  std::array<int, 2> toes = {-1, -1};  // left, right
  Eigen::Matrix3d world_from_file;     // a rotation: z up, x forward of the zero pose or, if nobody stands there, of
                                       // the first frame
  bool zero_pose_stands = false;       // the zero pose is a person standing upright
  double leg = 0.0;                    // hip to ankle, file's unit
  double metres = 1.0;                 // of the file's unit, as far as the leg tells
  std::vector<std::string> notes;

  bool has(BodyJoint ours) const { return joint[index(ours)] >= 0; }
  std::size_t of(BodyJoint ours) const { return static_cast<std::size_t>(joint[index(ours)]); }
};

// Throws InvalidInput naming the first joint that cannot be told.
BvhJoints find_joints(const BvhMotion& bvh, const std::string& name);

}  // namespace rotunda::recon
