#include "playback/live_player.h"

#include <chrono>
#include <cmath>

#include "playback/display/window.h"

namespace rotunda::playback {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLook_s = 0.01;                   // for a new surface
constexpr auto kOldest = std::chrono::seconds(1);  // a picture is drawn anew: something else may have covered it

struct LiveControl {
  bool held = false, ended = false;
};

void press(LiveStage& stage, LiveControl& control, Key key) {
  constexpr double kTurn = 0.08;  // radians a key press
  constexpr double kZoom = 1.08;
  auto& orbit = stage.orbit();
  switch (key) {
    case Key::left:
      return orbit.turn(-kTurn, 0.0);
    case Key::right:
      return orbit.turn(kTurn, 0.0);
    case Key::up:
      return orbit.turn(0.0, kTurn);
    case Key::down:
      return orbit.turn(0.0, -kTurn);
    case Key::plus:
      return orbit.zoom(kZoom);
    case Key::minus:
      return orbit.zoom(1.0 / kZoom);
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
    case Key::next:
    case Key::previous:
    case Key::map:
    case Key::follow:
    case Key::help:
      return;
  }
}

void apply(LiveStage& stage, LiveControl& control, const WindowInput& input) {
  for (const Key key : input.keys) press(stage, control, key);
  constexpr double kTurnPerHeight = 3.0;  // radians for a drag over the window's height
  stage.orbit().turn(-kTurnPerHeight * input.drag_x, kTurnPerHeight * input.drag_y);
  if (input.scroll != 0.0) stage.orbit().zoom(std::pow(1.1, input.scroll));
}

bool has_any(const WindowInput& input) {
  return !input.keys.empty() || input.drag_x != 0.0 || input.drag_y != 0.0 || input.scroll != 0.0;
}

}  // namespace

LivePlayReport play_live(const std::function<std::optional<LiveView>()>& newest, const LivePlayOptions& options) {
  Window window(
      {.title = "rotunda live", .width = options.width, .height = options.height, .fullscreen = options.fullscreen});
  LiveStage stage;
  LiveControl control;
  LivePlayReport report;
  const auto begin = Clock::now();
  cv::Size drawn;
  auto drawn_at = begin - kOldest;
  while (window.is_open() && !control.ended && !options.stop.stop_requested()) {
    const auto view = control.held ? std::nullopt : newest();
    if (view) {
      stage.show(*view);
      ++report.surfaces;
    }
    const auto input = window.take_input();
    apply(stage, control, input);
    const cv::Size size(window.width(), window.height());
    const auto now = Clock::now();
    if (!size.empty() && (view || has_any(input) || size != drawn || now - drawn_at >= kOldest)) {
      window.bind();
      stage.draw(size.width, size.height);
      window.present();
      ++report.pictures;
      drawn = size;
      drawn_at = now;
    }
    window.wait_for_input(kLook_s);
  }
  report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return report;
}

}  // namespace rotunda::playback
