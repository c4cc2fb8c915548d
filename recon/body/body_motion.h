#pragma once
// A person's motion: poses at a rate, of a Skeleton whose legs have a length. World frame, metres, floor at z = 0.
// Poses are turns a joint away from the T-pose that all skeletons share (skeleton.h), so they fit any body; only the
// path of the root belongs to the legs it was walked with.
#include <string>
#include <vector>

#include "recon/body/bvh.h"
#include "recon/body/pose.h"

namespace rotunda::recon {

struct BodyMotion {
  std::vector<Pose> poses;
  double frame_time = 0.04;        // seconds
  double leg_length = 0.0;         // hip to ankle of who moved, metres
  std::vector<std::string> notes;  // for the user: what was found and guessed
};

// Anyone's BVH. Joints are found by their names (joint_names.h); each of ours then turns as its counterpart does, seen
// from a pose that both share. That is the file's zero pose where a person stands in it, in T, A or with hanging arms:
// trunk, hands and feet are taken to be at rest in both, limbs are brought to the direction of theirs. Where nobody
// stands (all bones along one axis), the directions of bones and the axes about which knees and elbows are seen to bend
// take its place. Up, forward and the unit of the path come from the skeleton; its lowest sole stands on the floor and
// its path is centred on the stage.
struct BvhImportOptions {
  std::string name = "motion.bvh";  // for messages
  bool trust_angles = false;        // take angles as degrees even if they look like radians
};
// Throws InvalidInput: pelvis, legs or trunk cannot be told by their names, legs have no length, angles are radians.
BodyMotion import_bvh(const BvhMotion& bvh, const BvhImportOptions& options = {});

// The same motion by a body with other legs: the root's path scaled as they are.
std::vector<Pose> poses_for(const BodyMotion& motion, const Skeleton& skeleton);

}  // namespace rotunda::recon
