#pragma once
// What motion capture makes of a take: a template, and its pose in every frame. World, metres, z up.
#include <filesystem>
#include <vector>

#include "recon/body/body_tracker.h"
#include "recon/body/bvh.h"

namespace rotunda::recon {

struct CapturedMotion {
  BodyTemplate body;
  double fps = 25.0;
  std::size_t first_frame = 0;      // of the take
  std::vector<TrackedPose> frames;  // without gaps; lost ones hold what was there before
};

// Centimetres, y up, facing z, as other programs expect; offsets of the T-pose, end sites at crown, fingertips and
// toes.
BvhMotion bvh_of(const CapturedMotion& motion);

// JSON: joints with parents, measures, and per frame its number in the take, state, positions (world, metres),
// rotations (w x y z, in the parent's frame), confidence (0..1) and standard deviation (metres) of every joint. Throws
// std::system_error.
void write_joints_json(const std::filesystem::path& file, const CapturedMotion& motion);

// FOLDER/frame000000.ply a frame, numbered as in the take. Throws std::system_error.
void write_template_meshes(const std::filesystem::path& folder, const CapturedMotion& motion);

}  // namespace rotunda::recon
