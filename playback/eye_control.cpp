#include "playback/eye_control.h"

#include <cmath>

namespace rotunda::playback {
namespace {

constexpr double kTurn = 0.08;  // radians a key press
constexpr double kZoom = 1.08;
constexpr double kZoomPerNotch = 1.1;
constexpr double kTurnPerHeight = 3.0;  // radians for a drag over the window's height
constexpr double kStickTurn = 2.0;      // radians a second
constexpr double kStickZoom = 2.0;      // times a second

double beyond_dead(double push) {
  return std::abs(push) < kStickDead ? 0.0 : push;
}

}  // namespace

void turn_by_key(Key key, Orbit& orbit) {
  if (key == Key::left) orbit.turn(-kTurn, 0.0);
  if (key == Key::right) orbit.turn(kTurn, 0.0);
  if (key == Key::up) orbit.turn(0.0, kTurn);
  if (key == Key::down) orbit.turn(0.0, -kTurn);
}

void zoom_by_key(Key key, Orbit& orbit) {
  if (key == Key::plus) orbit.zoom(kZoom);
  if (key == Key::minus) orbit.zoom(1.0 / kZoom);
}

bool moves_eye(const WindowInput& input) {
  if (input.drag_x != 0.0 || input.drag_y != 0.0 || input.scroll != 0.0) return true;
  if (!input.gamepad) return false;
  const auto& pad = *input.gamepad;
  return beyond_dead(pad.right_right) != 0.0 || beyond_dead(pad.right_up) != 0.0 ||
         beyond_dead(pad.closer) != beyond_dead(pad.farther);
}

void move_eye(const WindowInput& input, Orbit& orbit, double seconds) {
  orbit.turn(-kTurnPerHeight * input.drag_x, kTurnPerHeight * input.drag_y);
  if (input.scroll != 0.0) orbit.zoom(std::pow(kZoomPerNotch, input.scroll));
  if (!input.gamepad) return;
  const auto& pad = *input.gamepad;
  orbit.turn(-kStickTurn * seconds * beyond_dead(pad.right_right), kStickTurn * seconds * beyond_dead(pad.right_up));
  orbit.zoom(std::pow(kStickZoom, seconds * (beyond_dead(pad.closer) - beyond_dead(pad.farther))));
}

}  // namespace rotunda::playback
