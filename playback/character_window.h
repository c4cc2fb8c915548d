#pragma once
// Steers a character in a window, with its state, a small map of its graph and help laid over the picture. The keys:
// character_desk.h.
#include <filesystem>
#include <stop_token>

#include "playback/player.h"
#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

struct CharacterPlayReport {
  long pictures = 0;
  double seconds = 0.0;       // from the first picture to the last
  double load_seconds = 0.0;  // from the call to the first picture
  int lost_contexts = 0;      // of the graphics driver: everything was made anew
};

// Returns when the window is closed, the operator quits, or it is asked to stop. Call it on the program's first thread.
// Throws DeviceError without a display, and what open_character throws.
CharacterPlayReport play_character(const std::filesystem::path& character, const recon::MotionGraph& graph,
                                   const PlayOptions& options = {});

}  // namespace rotunda::playback
