#pragma once
// The simulated studio as a folder of pictures, the form in which `rotunda take import` takes footage from elsewhere:
// DIR/images/<camera>/frame000000.png, DIR/background/<camera>.png, DIR/calibration.yaml, DIR/truth/ (truth.h).
#include <filesystem>
#include <functional>

#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {

// RGB as the sensor has it before the mosaic. `progress` is told the number of frames done. Throws std::system_error.
void write_picture_set(const std::filesystem::path& directory, SceneRenderer& studio, int frames,
                       const std::function<void(int)>& progress = {});

}  // namespace rotunda::simulator
