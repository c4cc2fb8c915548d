#pragma once
// A window where there is a desktop, the whole screen where there is none.
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

}  // namespace rotunda::playback
