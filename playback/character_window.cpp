#include "playback/character_window.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <thread>

#include "playback/character_view.h"
#include "playback/clip_loader.h"
#include "playback/display/window.h"
#include "playback/render/overlay.h"

namespace rotunda::playback {
namespace {

using Clock = std::chrono::steady_clock;

constexpr recon::Colour kBackground{24, 26, 30};
constexpr auto kPicturePeriod = std::chrono::microseconds(16'667);
constexpr double kTurn = std::numbers::pi / 12.0;  // of the character, a key press
constexpr double kFaster = 0.2;                    // m/s a key press
constexpr double kSlowMotion = 0.25;

double seconds_since(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

// All that keys and mouse change.
struct Desk {
  std::vector<std::string> choices;  // behind the keys 1, 2, ...
  bool frozen = false, slow = false, help = false, ended = false;
  double speed = 0.0;  // asked for, m/s
  DrawOptions draw;
};

std::vector<std::string> choices_of(const recon::MotionGraph& graph) {
  std::vector<std::string> choices;
  for (const auto& state : graph.states) choices.push_back(state.name);
  for (const auto& transition : graph.transitions)
    if (transition.from == transition.to) choices.push_back(transition.name);
  return choices;
}

void ask_speed(Desk& desk, CharacterPlayer& player, double change) {
  const auto& graph = player.graph();
  if (desk.speed == 0.0) desk.speed = graph.clip(graph.state(player.wanted()).clip).speed;
  desk.speed = std::clamp(desk.speed + change, 0.0, 6.0);
  player.command({.speed = desk.speed});
}

void press(Key key, Desk& desk, CharacterPlayer& player, Orbit& orbit, const Orbit& front) {
  constexpr double kZoom = 1.08;
  switch (key) {
    case Key::left:
      return player.command({.turn = kTurn});
    case Key::right:
      return player.command({.turn = -kTurn});
    case Key::up:
      return ask_speed(desk, player, kFaster);
    case Key::down:
      return ask_speed(desk, player, -kFaster);
    case Key::plus:
      return orbit.zoom(kZoom);
    case Key::minus:
      return orbit.zoom(1.0 / kZoom);
    case Key::next:
      desk.frozen = true;
      return player.advance(1.0 / player.graph().fps);
    case Key::previous:
      desk.slow = !desk.slow;
      return;
    case Key::space:
      desk.frozen = !desk.frozen;
      return;
    case Key::home: {
      const auto target = orbit.target;
      orbit = front;
      orbit.target = target;
      return;
    }
    case Key::grey:
      desk.draw.shading = desk.draw.shading == Shading::grey ? Shading::colour : Shading::grey;
      return;
    case Key::help:
      desk.help = !desk.help;
      return;
    case Key::quit:
      desk.ended = true;
      return;
  }
}

void apply(const WindowInput& input, Desk& desk, CharacterPlayer& player, Orbit& orbit, const Orbit& front) {
  for (const Key key : input.keys) press(key, desk, player, orbit, front);
  for (const int digit : input.digits)
    if (static_cast<std::size_t>(digit) <= desk.choices.size()) {
      player.command({.state = desk.choices[static_cast<std::size_t>(digit - 1)]});
      desk.speed = 0.0;
    }
  constexpr double kTurnPerHeight = 3.0;  // radians for a drag over the window's height
  orbit.turn(-kTurnPerHeight * input.drag_x, kTurnPerHeight * input.drag_y);
  if (input.scroll != 0.0) orbit.zoom(std::pow(1.1, input.scroll));
}

std::vector<std::string> help_lines(const Desk& desk, const CharacterPlayer& player, double pictures_a_second) {
  std::vector<std::string> lines{fmt::format("{}{}   {:.0f} pictures/s", player.doing(),
                                             player.doing() == player.wanted() ? "" : " > " + player.wanted(),
                                             pictures_a_second)};
  if (!desk.help) return lines;
  for (std::size_t i = 0; i < desk.choices.size() && i < 9; ++i)
    lines.push_back(fmt::format("{}  {}", i + 1, desk.choices[i]));
  for (const char* line :
       {"left, right  turn", "up, down  faster, slower", "mouse  look round, wheel or + -  closer, farther",
        "space  freeze    .  step    ,  slow motion", "Home  from the front    g  grey", "F1  this help    q  end"})
    lines.emplace_back(line);
  return lines;
}

}  // namespace

CharacterPlayReport play_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                                   const PlayOptions& options) {
  const auto called = Clock::now();
  Window window(
      {.title = "rotunda", .width = options.width, .height = options.height, .fullscreen = options.fullscreen});
  CharacterView view(character, graph);
  CharacterPlayer player(graph, view.renderer().roots());
  ClipLoader loader(character, graph);
  Overlay overlay;
  Desk desk{.choices = choices_of(graph)};
  Orbit front = view.orbit_for(static_cast<double>(options.width) / options.height);
  front.azimuth = -0.6;
  view.orbit() = front;
  CharacterPlayReport report{.load_seconds = seconds_since(called)};
  const auto begin = Clock::now();
  auto last = begin;
  double period = 1.0 / 60.0;
  while (window.is_open() && !desk.ended && !options.stop.stop_requested() &&
         (options.picture_limit == 0 || report.pictures < options.picture_limit)) {
    const auto now = Clock::now();
    const double passed = std::chrono::duration<double>(now - last).count();
    last = now;
    period += 0.1 * (passed - period);
    for (const auto& loaded : loader.take()) view.renderer().adopt(loaded.clip, loaded.frame, loaded.image);
    if (!desk.frozen) player.advance(std::min(passed, 0.1) * (desk.slow ? kSlowMotion : 1.0));
    view.follow(player.appearance(), report.pictures == 0 ? 1e9 : passed);
    if (window.width() > 0 && window.height() > 0) {
      window.bind();
      view.draw(player.appearance(), window.width(), window.height(), {kBackground, true, desk.draw});
      overlay.draw(text_card(help_lines(desk, player, 1.0 / period)), 12, 12, window.width(), window.height());
    }
    window.present();
    ++report.pictures;
    apply(window.take_input(), desk, player, view.orbit(), front);
    std::this_thread::sleep_until(now + kPicturePeriod);
  }
  report.seconds = seconds_since(begin);
  return report;
}

}  // namespace rotunda::playback
