#pragma once
// What the live way knows of the studio: the rig's calibration and volume, the plates that `rotunda plate` recorded.
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "config/rig_config.h"
#include "recon/frame_reconstruction.h"

namespace rotunda::recon {

struct LiveStudio {
  StudioViews views;  // in the slots' order, with live keys
  Eigen::AlignedBox3d volume;
  std::vector<std::string> remarks;  // what makes it slow or worse, a sentence each
};

// `cameras`: a slot each of the sets to come; `plates`: <camera>.png, where there are any; `first`: one of the sets,
// for the pictures' formats, and for a plate fitted to the picture where none was recorded (a camera without a frame in
// it gets no live key). Reads files. Throws InvalidInput that says what to do for a rig without calibration, or whose
// calibration does not fit its cameras; ConfigError, CorruptData.
LiveStudio live_studio(const config::RigConfig& rig, std::span<const capture::CameraId> cameras,
                       const std::filesystem::path& plates, const capture::FrameSet& first);

}  // namespace rotunda::recon
