#pragma once
// What a person does with keys, mouse and gamepad, as values. Screen: right and down are positive; of sticks, away from
// the hand is up and positive.
#include <cstddef>
#include <optional>
#include <vector>

namespace rotunda::playback {

enum class Key {
  left,
  right,
  up,
  down,
  space,
  plus,
  minus,
  next,
  previous,
  home,
  grey,
  map,
  follow,
  pictures,
  help,
  quit,
  // of editors
  undo,
  redo,
  save,
  remove,
  add,
  next_item,
  previous_item,
  both_sides,
  residuals,
  rest
};

enum class Button { a, b, x, y, start, back };

struct Gamepad {
  double left_right = 0.0, left_up = 0.0;    // of the left stick, -1 to 1
  double right_right = 0.0, right_up = 0.0;  // of the right one
  double closer = 0.0, farther = 0.0;        // triggers, 0 to 1
};

// Pixels of what is drawn into; (0, 0) is the middle of the top left one.
struct MousePlace {
  double x = 0.0, y = 0.0;
};

struct MouseClick {
  MousePlace at;
  std::size_t after_keys = 0;  // so many of the keys were pressed before
};

// Where the button went down, and where the mouse is, or was when it was let go.
struct MouseDrag {
  MousePlace from, to;
};

struct WindowInput {
  std::vector<Key> keys;                // pressed or repeated since last asked
  std::vector<int> digits;              // of these, 1 to 9
  double drag_x = 0.0, drag_y = 0.0;    // of the mouse with the left button down, in window heights
  double shift_x = 0.0, shift_y = 0.0;  // with another button down
  double scroll = 0.0;                  // notches, away from the hand is positive
  std::vector<MouseClick> clicks;       // of the left button, pressed and let go in one place
  std::optional<MouseDrag> dragged;     // the last of it with the left button down
  std::optional<Gamepad> gamepad;       // the first there is, as it is held now
  std::vector<Button> buttons;          // of it, pressed since last asked
};

}  // namespace rotunda::playback
