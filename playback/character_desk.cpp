#include "playback/character_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "playback/eye_control.h"

namespace rotunda::playback {
namespace {

constexpr double kTurn = std::numbers::pi / 12.0;  // of the character, a key press
constexpr double kFaster = 0.2;                    // m/s a key press
constexpr std::size_t kRemembered = 1500;          // pictures: 25 seconds at sixty a second
constexpr double kSameSpeed = 0.15;                // m/s
constexpr double kSameWay = 0.05;                  // radians

std::vector<std::string> choices_of(const recon::MotionGraph& graph) {
  std::vector<std::string> choices;
  for (const auto& state : graph.states) choices.push_back(state.name);
  for (const auto& transition : graph.transitions)
    if (transition.from == transition.to) choices.push_back(transition.name);
  return choices;
}

}  // namespace

CharacterDesk::CharacterDesk(const recon::MotionGraph& graph, const Orbit& front)
    : choices_(choices_of(graph)), front_(front) {
  for (const auto& state : graph.states) fastest_ = std::max(fastest_, graph.clip(state.clip).speed);
}

void CharacterDesk::choose(std::size_t choice, CharacterPlayer& player) {
  if (choice >= choices_.size()) return;
  player.command({.state = choices_[choice]});
  speed_ = 0.0;
}

void CharacterDesk::change_speed(CharacterPlayer& player, double change) {
  const auto& graph = player.graph();
  if (speed_ == 0.0) speed_ = graph.clip(graph.state(player.wanted()).clip).speed;
  speed_ = std::clamp(speed_ + change, 0.0, 1.5 * fastest_);
  player.command({.speed = speed_});
}

// Forwards through what was seen already, then on by a frame.
void CharacterDesk::step(CharacterPlayer& player, int pictures) {
  if (pictures < 0) {
    back_ = std::min(back_ + 1, seen_.empty() ? 0 : seen_.size() - 1);
  } else if (back_ > 0) {
    --back_;
  } else {
    player.advance(1.0 / player.graph().fps);
    seen_.push_back(player.appearance());
  }
}

void CharacterDesk::go_home(Orbit& orbit) {
  const auto target = orbit.target;
  orbit = front_;
  orbit.target.head<2>() = target.head<2>();
  home_ = true;
}

void CharacterDesk::press_own(Key key, CharacterPlayer& player) {
  if (key == Key::left) player.command({.turn = kTurn});
  if (key == Key::right) player.command({.turn = -kTurn});
  if (key == Key::up) change_speed(player, kFaster);
  if (key == Key::down) change_speed(player, -kFaster);
  if (key == Key::map) map_ = !map_;
}

void CharacterDesk::press(Key key, CharacterPlayer& player, Orbit& orbit) {
  switch (keys_.press(key, orbit)) {
    case Pressed::done:
    case Pressed::follow:
      return;
    case Pressed::step_on:
      return step(player, 1);
    case Pressed::step_back:
      return step(player, -1);
    case Pressed::home:
      return go_home(orbit);
    case Pressed::own:
      return press_own(key, player);
  }
}

// The left stick away from the hand is away from the eye. Let go, it asks for standing once.
void CharacterDesk::push_stick(const Gamepad& pad, const Orbit& orbit, CharacterPlayer& player) {
  const double push = std::hypot(pad.left_right, pad.left_up);
  const double speed = push < kStickDead ? 0.0 : std::min(1.0, push) * fastest_;
  if (std::abs(speed - pushed_) > kSameSpeed || (speed == 0.0 && pushed_ != 0.0)) {
    player.command({.speed = speed});
    pushed_ = speed_ = speed;
  }
  if (speed > 0.0) {
    const double away = orbit.azimuth + std::numbers::pi, to_the_left = std::atan2(-pad.left_right, pad.left_up);
    if (std::abs(std::remainder(away + to_the_left - player.aim(), 2.0 * std::numbers::pi)) > kSameWay)
      player.command({.heading = away + to_the_left});
  }
}

void CharacterDesk::apply(const WindowInput& input, CharacterPlayer& player, Orbit& orbit, double seconds) {
  for (const Key key : input.keys) press(key, player, orbit);
  for (const int digit : input.digits) choose(static_cast<std::size_t>(digit - 1), player);
  for (const Button button : input.buttons)
    if (keys_.press(button) == Pressed::own) choose(static_cast<std::size_t>(button), player);
  if (input.gamepad) push_stick(*input.gamepad, orbit, player);
  move_eye(input, orbit, seconds);
  shift_ += Eigen::Vector2d(input.shift_x, input.shift_y);
}

const Appearance& CharacterDesk::go_on(CharacterPlayer& player, double seconds) {
  if (!keys_.frozen()) {
    back_ = 0;
    player.advance(seconds * keys_.pace());
    seen_.push_back(player.appearance());
  }
  if (seen_.empty()) seen_.push_back(player.appearance());
  while (seen_.size() > kRemembered) seen_.pop_front();
  return seen_[seen_.size() - 1 - back_];
}

Eigen::Vector2d CharacterDesk::take_shift() {
  return std::exchange(shift_, Eigen::Vector2d::Zero());
}

std::vector<std::string> CharacterDesk::lines(const CharacterPlayer& player, const std::string& rate) const {
  std::string first = player.doing();
  if (player.doing() != player.wanted()) first += " > " + player.wanted();
  if (back_ > 0) first += fmt::format("   {} back", back_);
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < choices_.size() && i < 9; ++i) keys.push_back(fmt::format("{}  {}", i + 1, choices_[i]));
  keys.emplace_back("left, right  turn    up, down  faster, slower    m  map");
  keys.emplace_back("gamepad  left stick  where to and how fast, A B X Y  as 1 to 4");
  return keys_.lines(std::move(first), rate, std::move(keys));
}

}  // namespace rotunda::playback
