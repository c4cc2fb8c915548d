#pragma once
// Where the world's origin is: on the board that lay on the floor (x along it, z up), or in a camera.
#include <optional>
#include <span>
#include <string>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

// The board that lies on the floor: below every other board, before all cameras' upright side. Of several the one that
// most cameras saw. Nothing if no board was laid down.
std::optional<BoardKey> board_on_floor(const RigState& state, std::span<const Sighting> sightings,
                                       std::span<const Board> boards);

// Everything moved rigidly: new_from_old is applied to the world.
void move_world(RigState& state, const Eigen::Isometry3d& new_from_old);

struct WorldFrame {
  std::string where;   // in words
  std::string advice;  // empty if there is none
};

// Moves the world to `world_from`, a camera's name; else to the board on the floor; else to the first camera.
// Throws InvalidInput if there is no such camera.
WorldFrame take_world_frame(RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                            std::span<const std::string> moments, const std::string& world_from);

}  // namespace rotunda::capture
