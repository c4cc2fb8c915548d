#pragma once
// rotunda calibrate --convert: calibrations of other programs in and out (docs/calibration-formats.md).
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace rotunda::rig {

struct ConvertRequest {
  std::filesystem::path in;      // --convert; empty: nothing to convert
  std::filesystem::path out;     // -o
  std::filesystem::path images;  // --images: pictures whose sizes are the cameras'
  std::string from, to;          // formats by name; empty: by content, by the ending
  std::string image_size;        // "720x576" for cameras whose size nothing tells
  std::string unit;              // replaces the file's
  bool mirror = false;
  bool allow_loss = false;
  bool force = false;  // --force: what is there may be replaced
};

// The options that only a conversion has; -o, --images and --force are the command's.
void add_convert_options(CLI::App& calibrate, ConvertRequest& request);
// Exit code 1 if something was lost, which --allow-loss permits. Throws InvalidInput, ConfigError, std::system_error.
int convert_calibration(const ConvertRequest& request, bool as_json);

}  // namespace rotunda::rig
