#pragma once
// What `rotunda play --live` and rotunda-kiosk share: the daemon's live surfaces in a window, or as one picture.
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "playback/display/open_display.h"

namespace rotunda::rig {

struct LiveViewRequest {
  std::filesystem::path socket;
  bool with_pictures = false;  // of four cameras with their mattes, beside the surface
  bool fullscreen = false;
  playback::DisplayKind display = playback::DisplayKind::window;
  std::filesystem::path device;   // /dev/dri/cardN, without a desktop; empty: the first with a display
  std::string connector;          // of it
  std::filesystem::path picture;  // PNG instead of a window: needs no display
  long surfaces = 1;              // that come before it is written
  std::vector<int> size;          // width, height in pixels; empty: 1280 x 720
  bool json = false;
};

// Returns an exit code. Throws DeviceError if no display is there, or no daemon or surface within some seconds.
int show_live(const LiveViewRequest& request, std::stop_token stop);

// A take's surfaces of live quality (recon/live_take.h), over and over at their rate; `picture` shows the one in the
// middle. Throws CorruptData, DeviceError without a display.
int show_live_take(const std::filesystem::path& file, const LiveViewRequest& request, std::stop_token stop);

}  // namespace rotunda::rig
