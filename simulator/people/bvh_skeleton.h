#pragma once
// Which joints of a BVH file are ours, and how the file's world lies in the stage's. Private to bvh_motion.
#include <array>
#include <string>
#include <vector>

#include "recon/body/bvh.h"
#include "simulator/people/skeleton.h"

namespace rotunda::simulator {

struct BvhSkeleton {
  std::array<int, kJoints> joint;  // of the file, for each of ours; -1: none
  Eigen::Matrix3d
      world_from_file;  // a rotation: z up, x forward of the zero pose or, if nobody stands there, the first frame
  bool zero_pose_stands = false;  // the zero pose is a person standing upright
  double leg = 0.0;               // hip to ankle, file's unit
  std::vector<std::string> notes;

  bool has(Joint ours) const { return joint[index(ours)] >= 0; }
  std::size_t of(Joint ours) const { return static_cast<std::size_t>(joint[index(ours)]); }
};

// Throws InvalidInput naming the first joint that cannot be told.
BvhSkeleton find_skeleton(const recon::BvhMotion& bvh, const std::string& name);

}  // namespace rotunda::simulator
