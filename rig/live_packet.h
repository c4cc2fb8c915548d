#pragma once
// What the daemon sends its viewers with every live surface.
#include <cstdint>
#include <string>
#include <vector>

namespace rotunda::rig {

struct LivePicture {
  std::string camera;
  std::vector<std::uint8_t> jpeg;  // the picture, its matte to the right of it, both small
};

struct LivePacket {
  std::vector<std::uint8_t> surface;  // recon/live_surface.h
  std::vector<LivePicture> pictures;
};

}  // namespace rotunda::rig
