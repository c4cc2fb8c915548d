#pragma once
// What the program itself makes of a simulated rig: its calibration from the pictures of a board walk.
#include <filesystem>
#include <string>
#include <vector>

#include "capture/camera_model.h"

namespace rotunda::bench {

// The cameras `found`, in the world of those that are true: moved rigidly, so that their centres lie nearest.
std::vector<capture::CameraModel> aligned_cameras(std::vector<capture::CameraModel> found,
                                                  const std::vector<capture::CameraModel>& truth);

// Sixty moments of the act "board" before these cameras, calibrated, aligned. `keep`: a folder where that is left under
// the rig's name and taken from the next time; none if empty. Throws InvalidInput if a camera could not be calibrated.
std::vector<capture::CameraModel> own_calibration(const std::string& rig,
                                                  const std::vector<capture::CameraModel>& truth,
                                                  const std::filesystem::path& keep);

}  // namespace rotunda::bench
