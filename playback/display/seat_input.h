#pragma once
// Keyboards and mice of this machine's seat (libinput), without a desktop, as they come and go. What they reach has no
// pointer: a mouse turns and zooms, it does not click.
#include <chrono>
#include <memory>
#include <optional>

#include "playback/display/window_input.h"

namespace rotunda::playback {

// By its place on the keyboard, as evdev numbers it (linux/input-event-codes.h): letters as on an American one.
std::optional<Key> key_of_evdev(unsigned code);

class SeatInput {
 public:
  SeatInput();
  ~SeatInput();
  SeatInput(const SeatInput&) = delete;
  SeatInput& operator=(const SeatInput&) = delete;

  bool has_keyboard() const;
  int fd() const;         // readable when something happened; -1: there is no input
  void read(int height);  // what happened; pixels of the display
  WindowInput take();     // with keys that are held repeated

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rotunda::playback
