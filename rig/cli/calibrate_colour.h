#pragma once
// rotunda calibrate --colour: cameras' colours made to agree.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace rotunda::rig {

struct ColourRequest {
  std::filesystem::path take;                 // a reconstructed take whose surface is the card; or empty and
  std::filesystem::path images;               // pictures of boards, whose white is the card,
  std::vector<std::filesystem::path> boards;  // of these board files
  std::filesystem::path calibration;          // to be completed; empty: the take's
  std::filesystem::path out;
  bool force = false;
};

// Finds each camera's colour matrix and writes the calibration with them. Throws InvalidInput, ConfigError,
// CorruptData.
int calibrate_colour(const ColourRequest& request, bool as_json);

}  // namespace rotunda::rig
