#pragma once
// The cameras of a rig file: camera_defaults, then a mapping a camera.
#include <vector>

#include "config/checked_yaml.h"
#include "config/rig_config.h"

namespace rotunda::config {

std::vector<CameraConfig> read_cameras(CheckedMap& root, Problems& problems);

}  // namespace rotunda::config
