#pragma once
// Steers a character in a window. Keys: 1 to 9 its states and actions; left, right turn it; up, down its speed; the
// dragged mouse goes round it, the wheel and + - zoom; space freezes; , plays a quarter as fast; . steps; Home looks
// from the front; g grey; F1 help; q or Esc ends.
#include <filesystem>
#include <stop_token>

#include "playback/player.h"
#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

struct CharacterPlayReport {
  long pictures = 0;
  double seconds = 0.0;       // from the first picture to the last
  double load_seconds = 0.0;  // from the call to the first picture
};

// Returns when the window is closed, the operator quits, or it is asked to stop. Call it on the program's first thread.
// Throws DeviceError without a display, and what open_character throws.
CharacterPlayReport play_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                                   const PlayOptions& options = {});

}  // namespace rotunda::playback
