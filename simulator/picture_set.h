#pragma once
// The simulated studio as a folder of pictures, the form in which `rotunda take import` takes footage from elsewhere:
// DIR/images/<camera>/frame000000.png, DIR/background/<camera>.png, DIR/calibration.yaml, DIR/truth/ (truth.h).
#include <filesystem>
#include <functional>
#include <stop_token>

#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {

// RGB as the sensor has it before the mosaic. `progress` is told the number of frames done. Returns it; fewer than
// `frames` if stopped. Throws std::system_error.
int write_picture_set(const std::filesystem::path& directory, SceneRenderer& studio, int frames,
                      const std::stop_token& stop = {}, const std::function<void(int)>& progress = {});

}  // namespace rotunda::simulator
