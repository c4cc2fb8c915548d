#pragma once
// rotunda calibrate --colour: cameras' colours made to agree.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace rotunda::rig {

struct ColourRequest {
  std::filesystem::path take;         // a reconstructed take whose surface is the card
  std::filesystem::path calibration;  // to be completed; empty: the take's
  std::filesystem::path out;
  bool force = false;
};

// Finds each camera's colour matrix and writes the calibration with them. Throws InvalidInput, ConfigError,
// CorruptData.
int calibrate_colour(const ColourRequest& request, bool as_json);

}  // namespace rotunda::rig
