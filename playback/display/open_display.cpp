#include "playback/display/open_display.h"

#include <chrono>
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

int with_display(DisplayOptions options, const std::function<void(Display&)>& use) {
  using Clock = std::chrono::steady_clock;
  constexpr int kMostOnEnd = 10;
  constexpr auto kSoon = std::chrono::seconds(5);
  for (int lost = 0, on_end = 0;; ++lost) {
    const auto begin = Clock::now();
    const auto display = open_display(options);
    try {
      use(*display);
      return lost;
    } catch (const ContextLost&) {
      on_end = Clock::now() - begin < kSoon ? on_end + 1 : 0;
      if (on_end == kMostOnEnd) throw;
      if (display->width() <= 0 || display->height() <= 0) continue;
      options.window.width = display->width();
      options.window.height = display->height();
    }
  }
}

}  // namespace rotunda::playback
