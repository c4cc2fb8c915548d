#pragma once
// A captured motion as binary glTF 2.0: a node a joint, turned by one animation, the template's segments hanging on
// their joints. Metres; y up by a turned node above the pelvis, as other exports of ours stand.
#include <filesystem>

#include "recon/body/captured_motion.h"

namespace rotunda::recon {

// Throws InvalidInput for a motion without frames, std::system_error if the file cannot be written.
void write_motion_glb(const std::filesystem::path& file, const CapturedMotion& motion);

}  // namespace rotunda::recon
