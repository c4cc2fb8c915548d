#pragma once
// How hands move the spectator's eye, alike in every window: arrows and the dragged mouse go round, + - and the wheel
// zoom; a gamepad's right stick goes round, its triggers zoom.
#include "playback/display/window_input.h"
#include "playback/viewpoint.h"

namespace rotunda::playback {

inline constexpr double kStickDead = 0.15;  // of a stick's way: none rests quite in the middle

void turn_by_key(Key key, Orbit& orbit);  // arrows; others do nothing
void zoom_by_key(Key key, Orbit& orbit);  // + and -; others do nothing
// Mouse, wheel and, held for `seconds`, the gamepad: whether they do anything, and what.
bool moves_eye(const WindowInput& input);
void move_eye(const WindowInput& input, Orbit& orbit, double seconds);

}  // namespace rotunda::playback
