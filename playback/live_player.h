#pragma once
// Shows live surfaces in a window, or on a whole screen without a desktop, as they come, seen by an eye that the
// operator turns about the performer. Keys: arrows and the dragged mouse go round; + - and the wheel zoom; space holds
// the surface; Home looks from the front again; g shows the bare shape in grey; q or Esc ends.
#include <functional>
#include <optional>
#include <stop_token>

#include "playback/display/open_display.h"
#include "playback/live_stage.h"

namespace rotunda::playback {

struct LivePlayOptions {
  int width = 1280, height = 720;  // pixels
  bool fullscreen = false;
  DisplayKind display = DisplayKind::window;
  KmsOptions screen;  // without a desktop
  std::stop_token stop;
};

struct LivePlayReport {
  long pictures = 0;  // drawn in the window
  long surfaces = 0;  // shown
  double seconds = 0.0;
  int lost_contexts = 0;  // of the graphics driver: everything was made anew
};

// `newest`: the newest view that was not handed yet, or nothing; never waits. Returns when the window is closed, the
// operator quits, or it is asked to stop. Call it on the program's first thread. Throws DeviceError without a display,
// and what `newest` throws.
LivePlayReport play_live(const std::function<std::optional<LiveView>()>& newest, const LivePlayOptions& options);

}  // namespace rotunda::playback
