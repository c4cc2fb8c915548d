#pragma once
// graph.yaml: a character's motion graph as people read and change it (docs/character-format.md). Angles in degrees,
// lengths in metres unless the key says mm.
#include <filesystem>

#include "recon/motion/motion_graph.h"

namespace rotunda::recon {

// In one step that leaves the old file or the new one. Throws std::system_error.
void write_graph(const std::filesystem::path& file, const MotionGraph& graph);

// Throws ConfigError with every mistake, its line, column and key: names that are not there, frames beyond a clip,
// cycles that do not go back; InvalidInput if there is no such file.
MotionGraph read_graph(const std::filesystem::path& file);

}  // namespace rotunda::recon
