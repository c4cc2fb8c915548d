#pragma once
// Which cameras the simulated studio serves, and where: from a rig file, or by number alone.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "simulator/gige/camera_options.h"

namespace rotunda::simulator {

struct ServedStudio {
  std::vector<GigeCameraOptions> devices;     // one a camera
  std::vector<capture::CameraModel> cameras;  // the same order
  std::string person = "alex", act = "walk";
  std::uint32_t seed = 1;
};

// The cameras of a rig file where its calibration says they stand. Throws ConfigError for a bad file and InvalidInput
// for one that does not describe GigE Vision cameras on this machine: no calibration, a camera missing from it or of
// another size, an address that is not of 127.0.0.0/8, different pixel formats.
ServedStudio studio_of_rig(const std::filesystem::path& rig_file);

// `cameras` of camera_layout's, 720 x 576, on 127.0.0.1 upwards.
ServedStudio studio_of_size(int cameras);

}  // namespace rotunda::simulator
