#pragma once
// Records the empty studio: a picture a camera, the mean of many, in storage's hidden folder .plate; takes that are
// recorded afterwards keep a copy (docs/take-format.md: background/).
#include <filesystem>

#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/daemon/camera_fleet.h"

namespace rotunda::rig {

// Triggers the cameras so many times and waits for it: frame sets / rate seconds and a little. The plates before are
// replaced, camera by camera, each in one step. Throws what FrameSetStream throws, DeviceError when no camera gave two
// pictures, std::system_error.
PlateReport record_plate(const config::RigConfig& rig, CameraFleet& fleet, std::uint64_t frame_sets);

std::filesystem::path plate_folder(const std::filesystem::path& takes);

}  // namespace rotunda::rig
