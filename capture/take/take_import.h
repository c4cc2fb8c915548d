#pragma once
// Makes a take of somebody's pictures: DIR/<camera>/*.png (or jpg), sorted by name, one a frame, with a calibration.
// 2 to 64 cameras, each of its own size; 8-bit RGB or grey. Kept as RGB, lossless. The take appears whole or not at
// all: it is made in a hidden folder beside its place, which goes away if anything fails.
#include <cstddef>
#include <filesystem>
#include <stop_token>
#include <string>

#include "capture/take/take.h"
#include "capture/take/take_verify.h"

namespace rotunda::capture {

struct TakeImportOptions {
  std::string name;                   // of the take
  std::filesystem::path takes;        // where takes lie; made if missing
  std::filesystem::path images;       // DIR/<camera>/*.png
  std::filesystem::path calibration;  // calibration.yaml; its order of cameras becomes the take's
  std::filesystem::path background;   // DIR/<camera>.png, the empty studio; may be empty
  std::filesystem::path mattes;       // DIR/<camera>/*.png, as read_matte takes them, as many as images; or none
  double fps = 25.0;
  std::string note;
};

// Throws InvalidInput that names every camera and file that does not fit (a camera in one place and not in the other,
// fewer pictures than the rest, another size than the calibration's, not a picture), ConfigError for the calibration,
// std::system_error for the disk, operation_canceled when stopped. `progress` counts pictures; it is called by
// several threads, one at a time.
TakeInfo import_take(const TakeImportOptions& options, const Progress& progress = {}, std::stop_token stop = {});

}  // namespace rotunda::capture
