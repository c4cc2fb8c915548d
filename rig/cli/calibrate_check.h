#pragma once
// rotunda calibrate --check: has a camera moved since? A take against the empty studio that was recorded with it, two
// folders of pictures of the empty studio, or new pictures of boards against the calibration.
#include <filesystem>
#include <stop_token>
#include <vector>

namespace rotunda::rig {

struct CheckRequest {
  std::filesystem::path take;         // its first pictures are looked at
  std::filesystem::path background;   // DIR/<camera>.png as it was; empty: the take's own
  std::filesystem::path images;       // DIR/<camera>/* with boards
  std::filesystem::path calibration;  // what they are held against
  std::vector<std::filesystem::path> boards;
};

// Prints a line a camera; kDoneWithLoss if one has moved or cannot be told of. Throws InvalidInput, ConfigError.
int check_cameras(const CheckRequest& request, bool as_json, const std::stop_token& stop);

}  // namespace rotunda::rig
