#pragma once
// rotunda calibrate --images and --live: pictures of boards, from a folder or the running rig, to calibration.yaml and
// report.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace rotunda::rig {

struct PicturesRequest {
  std::filesystem::path images, out, report, intrinsics;
  std::vector<std::filesystem::path> boards;
  std::string world_from;
  bool bend = false, force = false;
};

// All options but --images, -o and --force, which other ways of calibrating share.
void add_picture_options(CLI::App& calibrate, PicturesRequest& request);

// Throws InvalidInput, ConfigError, std::system_error. A rejected calibration is not written unless forced.
int calibrate_pictures(const PicturesRequest& request, bool as_json, const std::stop_token& stop);

// The same from the rig of this daemon while somebody walks with the board; `images`: a new folder that keeps the
// pictures, empty: none. A stop request ends the walk, not the calibration after it. Throws DeviceError too.
int calibrate_live(const PicturesRequest& request, const std::filesystem::path& daemon, bool as_json,
                   const std::stop_token& stop);

}  // namespace rotunda::rig
