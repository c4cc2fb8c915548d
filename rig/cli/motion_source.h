#pragma once
// Where `rotunda animate` has its motion from.
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "recon/body/body_motion.h"
#include "recon/body/captured_motion.h"
#include "rig/cli/command_line.h"

namespace rotunda::rig {

struct MotionSource {
  std::filesystem::path file;  // a BVH, a geometry video, a character's folder, or a take's name or folder
  std::string clip;            // of the character
  std::string frames;          // A:B; empty: all
  std::optional<std::filesystem::path> calibration;  // of the take, if not its own
  bool trust_angles = false;                         // of the BVH: degrees though they look like radians
};

bool is_take(const MotionSource& source);

// Of who is in a take, a geometry video or a clip. Throws as capture_motion does, and std::system_error
// (operation_canceled) when stopped.
recon::CapturedMotion capture(const CommandLine& line, const MotionSource& source, const std::stop_token& stop);

// Of any source. Throws as capture and read_bvh do, InvalidInput for frames that are not in it.
recon::BodyMotion read_motion(const CommandLine& line, const MotionSource& source, const std::stop_token& stop);

}  // namespace rotunda::rig
