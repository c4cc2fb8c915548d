#pragma once
// What joints of anyone's skeleton are, by their names: MotionBuilder, Mixamo, CMU (also its ASF names: lfemur,
// lhumerus), Rokoko, Bandai, LAFAN1, Unreal, VRM, DAZ, Biovision's own (LeftHip, LeftKnee, LeftCollar, LeftShoulder,
// LeftElbow), SMPL, Kinect, OptiTrack, 3ds Max' Biped, Blender's Rigify, Rotunda's.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace rotunda::recon {

enum class Side { left, right };

enum class BodySegment : std::uint8_t {
  pelvis,
  spine,
  neck,
  head,
  clavicle,
  upper_arm,
  forearm,
  hand,
  thigh,
  shank,
  foot,
  toes
};

struct NamedJoint {
  BodySegment segment = BodySegment::pelvis;
  std::optional<Side> side;  // of limbs
};

// For each joint, given names and parents (an earlier joint or -1): what it is, if it can be told. Several joints may
// be spine and neck; of everything else each side has one at most, the highest in the hierarchy.
std::vector<std::optional<NamedJoint>> name_joints(const std::vector<std::string>& names,
                                                   const std::vector<int>& parents);

}  // namespace rotunda::recon
