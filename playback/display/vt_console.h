#pragma once
// The kernel's text console on this screen, put aside while this lives: it draws no text over the pictures, and what is
// typed reaches no shell. A process of its own gives it back, however this one ends.
#include <sys/types.h>

#include "capture/base/unique_fd.h"

namespace rotunda::playback {

class VtConsole {
 public:
  // Where there is no text console, or it is not this user's to put aside, nothing is done. `with_keyboard`: its
  // keyboard too, and with it Ctrl-C and the keys that change consoles. Make it before the graphics device is opened.
  explicit VtConsole(bool with_keyboard);
  ~VtConsole();
  VtConsole(const VtConsole&) = delete;
  VtConsole& operator=(const VtConsole&) = delete;

  bool put_aside() const { return keeper_ > 0; }

 private:
  capture::UniqueFd alive_;  // closed, by whatever end: the keeper gives the console back
  pid_t keeper_ = -1;
};

}  // namespace rotunda::playback
