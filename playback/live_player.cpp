#include "playback/live_player.h"

#include <chrono>
#include <tuple>

#include "playback/eye_control.h"

namespace rotunda::playback {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLook_s = 0.01;                   // for a new surface
constexpr auto kOldest = std::chrono::seconds(1);  // a picture is drawn anew: something else may have covered it

struct LiveControl {
  bool held = false, ended = false;
};

// What of the stage outlasts a graphics context.
struct Look {
  Orbit orbit;
  DrawOptions options;
};

void press(LiveStage& stage, LiveControl& control, Key key) {
  auto& orbit = stage.orbit();
  switch (key) {
    case Key::left:
    case Key::right:
    case Key::up:
    case Key::down:
      return turn_by_key(key, orbit);
    case Key::plus:
    case Key::minus:
      return zoom_by_key(key, orbit);
    case Key::home:
      return stage.look_from_front();
    case Key::grey:
      stage.options().shading = stage.options().shading == Shading::grey ? Shading::colour : Shading::grey;
      return;
    case Key::space:
      control.held = !control.held;
      return;
    case Key::quit:
      control.ended = true;
      return;
    default:
      return;
  }
}

void apply(LiveStage& stage, LiveControl& control, const WindowInput& input, double seconds) {
  for (const Key key : input.keys) press(stage, control, key);
  move_eye(input, stage.orbit(), seconds);
}

bool has_any(const WindowInput& input) {
  return !input.keys.empty() || moves_eye(input);
}

}  // namespace

LivePlayReport play_live(const std::function<std::optional<LiveView>()>& newest, const LivePlayOptions& options) {
  LiveControl control;
  std::optional<LiveView> shown;
  std::optional<Look> look;
  LivePlayReport report;
  const auto begin = Clock::now();
  const auto play_in = [&](Display& window) {
    LiveStage stage;
    if (shown) stage.show(*shown);
    if (look) std::tie(stage.orbit(), stage.options()) = std::tie(look->orbit, look->options);
    cv::Size drawn;
    auto looked_at = Clock::now();
    auto drawn_at = looked_at - kOldest;
    while (window.is_open() && !control.ended && !options.stop.stop_requested()) {
      auto view = control.held ? std::nullopt : newest();
      const bool is_new = view.has_value();
      if (view) {
        shown = std::move(view);
        stage.show(*shown);
        ++report.surfaces;
      }
      const auto input = window.take_input();
      const auto now = Clock::now();
      apply(stage, control, input, std::chrono::duration<double>(now - looked_at).count());
      look = {stage.orbit(), stage.options()};
      looked_at = now;
      const cv::Size size(window.width(), window.height());
      if (!size.empty() && (is_new || has_any(input) || size != drawn || now - drawn_at >= kOldest)) {
        window.bind();
        stage.draw(size.width, size.height);
        window.present();
        ++report.pictures;
        drawn = size;
        drawn_at = now;
      }
      window.wait_for_input(kLook_s);
    }
  };
  report.lost_contexts = with_display({.kind = options.display,
                                       .window = {.title = "rotunda live",
                                                  .width = options.width,
                                                  .height = options.height,
                                                  .fullscreen = options.fullscreen},
                                       .screen = options.screen},
                                      play_in);
  report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return report;
}

}  // namespace rotunda::playback
