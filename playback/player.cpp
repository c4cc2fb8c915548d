#include "playback/player.h"

#include <chrono>
#include <cmath>
#include <thread>

#include "playback/display/window.h"
#include "playback/frame_fetcher.h"
#include "playback/performer_place.h"
#include "playback/render/geometry_image_renderer.h"

namespace rotunda::playback {
namespace {

using Clock = std::chrono::steady_clock;

constexpr recon::Colour kBackground{24, 26, 30};
constexpr auto kPicturePeriod = std::chrono::microseconds(16'667);  // where the display does not hold us to its own

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

// Which frame is on, and how the eye stands: all that keys and mouse change.
struct PlayState {
  double frame = 0.0;  // with the part of a frame time that has passed
  bool paused = false, ended = false;
  Orbit orbit, front;
  DrawOptions draw;
};

void step(PlayState& state, int frames) {
  state.paused = true;
  state.frame = std::floor(state.frame) + frames;
}

void press(PlayState& state, Key key) {
  constexpr double kTurn = 0.08;  // radians a key press
  constexpr double kZoom = 1.08;
  switch (key) {
    case Key::left:
      return state.orbit.turn(-kTurn, 0.0);
    case Key::right:
      return state.orbit.turn(kTurn, 0.0);
    case Key::up:
      return state.orbit.turn(0.0, kTurn);
    case Key::down:
      return state.orbit.turn(0.0, -kTurn);
    case Key::plus:
      return state.orbit.zoom(kZoom);
    case Key::minus:
      return state.orbit.zoom(1.0 / kZoom);
    case Key::next:
      return step(state, 1);
    case Key::previous:
      return step(state, -1);
    case Key::space:
      state.paused = !state.paused;
      return;
    case Key::home:
      state.orbit = state.front;
      return;
    case Key::grey:
      state.draw.shading = state.draw.shading == Shading::grey ? Shading::colour : Shading::grey;
      return;
    case Key::map:
    case Key::follow:
    case Key::help:  // this player's keys stand in `rotunda play --help`
      return;
    case Key::quit:
      state.ended = true;
      return;
  }
}

void apply(PlayState& state, const WindowInput& input) {
  for (const Key key : input.keys) press(state, key);
  constexpr double kTurnPerHeight = 3.0;  // radians for a drag over the window's height
  state.orbit.turn(-kTurnPerHeight * input.drag_x, kTurnPerHeight * input.drag_y);
  if (input.scroll != 0.0) state.orbit.zoom(std::pow(1.1, input.scroll));
}

int frame_on(PlayState& state, int frames) {
  state.frame = std::fmod(std::fmod(state.frame, frames) + frames, frames);
  return std::min(static_cast<int>(state.frame), frames - 1);
}

}  // namespace

PlayReport play(recon::GeometryVideoReader& video, const PlayOptions& options) {
  const recon::GeometryVideoHeader& header = video.header();
  const FrameRange all{0, header.frame_count()};
  Window window(
      {.title = "rotunda", .width = options.width, .height = options.height, .fullscreen = options.fullscreen});
  GeometryImageRenderer renderer;
  FrameFetcher fetcher(video, {.level = options.level});
  PlayState state;
  state.front = state.orbit = orbit_around(header.box);
  renderer.upload(*fetcher.wait_for(0));
  PlayReport report{.frames = 1};
  int shown = 0;
  const auto begin = Clock::now();
  auto last = begin;
  while (window.is_open() && !state.ended && !options.stop.stop_requested() &&
         (options.picture_limit == 0 || report.pictures < options.picture_limit)) {
    const auto now = Clock::now();
    if (!state.paused) state.frame += seconds_between(last, now) * header.fps;
    last = now;
    const int frame = frame_on(state, all.count());
    if (frame != shown) {
      if (const auto image = state.paused ? fetcher.wait_for(frame) : fetcher.ready(frame)) {
        renderer.upload(*image);
        shown = frame;
        ++report.frames;
      } else {
        ++report.late;
      }
    }
    if (window.width() > 0 && window.height() > 0) {
      state.orbit.target = performer_place(performer_path(header), all, shown);
      window.bind();
      clear(kBackground);
      renderer.draw(state.orbit.viewpoint(window.width(), window.height()), state.draw);
    }
    window.present();
    ++report.pictures;
    apply(state, window.take_input());
    std::this_thread::sleep_until(now + kPicturePeriod);
  }
  report.seconds = seconds_between(begin, Clock::now());
  return report;
}

}  // namespace rotunda::playback
