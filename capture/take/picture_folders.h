#pragma once
// The folders of pictures an import starts from: which files belong to which camera, and what does not fit.
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"

namespace rotunda::capture {

// What is wrong, one sentence each, naming camera and file.
using Problems = std::vector<std::string>;

// DIR/<camera>/*.png|jpg|jpeg sorted by name, for each camera; what is missing or superfluous goes to `problems`.
std::vector<std::vector<std::filesystem::path>> list_pictures(const std::filesystem::path& folder,
                                                              std::span<const CameraModel> cameras, Problems& problems);

// DIR/<camera>.png|jpg|jpeg for each camera.
std::vector<std::filesystem::path> list_backgrounds(const std::filesystem::path& folder,
                                                    std::span<const CameraModel> cameras, Problems& problems);

// The picture if it can be read and has the camera's size; otherwise an empty one, and why in `problems`.
cv::Mat read_fitting_rgb(const std::filesystem::path& file, const CameraModel& camera, Problems& problems);
cv::Mat read_fitting_matte(const std::filesystem::path& file, const CameraModel& camera, Problems& problems);

}  // namespace rotunda::capture
