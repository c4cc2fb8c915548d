#include "playback/display/open_display.h"

#include <cstdlib>

namespace rotunda::playback {
namespace {

bool has_desktop() {
  const auto told = [](const char* variable) {
    const char* value = std::getenv(variable);
    return value && *value;
  };
  return told("DISPLAY") || told("WAYLAND_DISPLAY");
}

}  // namespace

std::unique_ptr<Display> open_display(const DisplayOptions& options) {
  const bool in_window =
      options.kind == DisplayKind::window || (options.kind == DisplayKind::automatic && has_desktop());
  if (in_window) return std::make_unique<Window>(options.window);
  return std::make_unique<KmsDisplay>(options.screen);
}

}  // namespace rotunda::playback
