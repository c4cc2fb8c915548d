#pragma once
// Anyone's motion capture on one of our people. Joints are found by their names (joint_names.h); each of ours then
// turns as its counterpart does, seen from a pose that both share. That pose comes from the file's zero pose where it
// is a person standing, in T, A or with hanging arms: trunk, hands and feet are taken to be at rest in both, limbs are
// brought to the direction of theirs. Where it is not (all bones along one axis), the directions of the bones and the
// axes about which knees and elbows bend, seen in the motion, take its place.
// Up and forward are found from the skeleton, its size from its legs, and so the unit of its path; the path is centred
// on the stage, the soles stand on the floor. Fingers hang by themselves.
#include <string>
#include <vector>

#include "recon/body/bvh.h"
#include "simulator/people/act.h"

namespace rotunda::simulator {

struct ImportedMotion {
  Motion motion;                   // as long as the file's; cyclic if its end meets its beginning on the 40 ms grid
  std::vector<std::string> notes;  // for the user: unit, axes, joints without counterpart
};

// `name`: of the motion, and for messages. Throws InvalidInput if pelvis, legs and trunk cannot be told by their names.
// Heel strikes are those of footfall.h.
ImportedMotion import_motion(const recon::BvhMotion& bvh, const std::string& name, const Skeleton& skeleton);

}  // namespace rotunda::simulator
