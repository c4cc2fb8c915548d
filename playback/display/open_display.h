#pragma once
// A window where there is a desktop, the whole screen where there is none.
#include <functional>
#include <memory>

#include "playback/display/kms_display.h"
#include "playback/display/window.h"

namespace rotunda::playback {

enum class DisplayKind { automatic, window, screen };

struct DisplayOptions {
  DisplayKind kind = DisplayKind::window;
  WindowOptions window;
  KmsOptions screen;  // without a desktop
};

// Throws DeviceError as they do.
std::unique_ptr<Display> open_display(const DisplayOptions& options);

// Calls `use` with a display; with a new one, a window as large as the old one was, whenever it throws ContextLost:
// what lives in the context belongs inside of it, what must outlast it outside. How often that was. Throws ContextLost
// itself when contexts are lost faster than one every five seconds, ten times on end.
int with_display(DisplayOptions options, const std::function<void(Display&)>& use);

}  // namespace rotunda::playback
