#pragma once
// `rotunda play` as a child of the page, in a window of its own.
#include <sys/types.h>

#include <optional>
#include <string>

#include "rig/tui/page_state.h"

namespace rotunda::rig {

class Replay {
 public:
  // Starts the player and says so; or says what to do where it cannot: no display, not reconstructed, one plays
  // already.
  std::string start(const ListedTake& take);
  // Something to say when the player has ended badly since the last call.
  std::optional<std::string> ended();

 private:
  pid_t child_ = -1;
  std::string take_;
};

}  // namespace rotunda::rig
