#pragma once
// What goes wrong in rigs, found in the residuals and named: a camera that was knocked, cameras that changed names, a
// mirrored picture.
#include <optional>
#include <string>

#include "capture/calibration/camera_graph.h"

namespace rotunda::capture {

// Why a group of cameras (graph.groups[group]) is apart from the first: no moment in common, or boards that agree on
// nothing (mirrored, out of step).
std::string why_apart(const CameraGraph& graph, std::size_t group, std::span<const CameraModel> cameras,
                      std::span<const Sighting> sightings, std::span<const Board> boards);

// Cameras that stand where the reference (cameras as they were, with poses) has another: names exchanged since.
std::vector<std::string> find_swaps(const RigState& state, std::span<const CameraModel> reference);

// A camera's pose at two stretches of moments: up to and with `last_before`, and after.
struct Knock {
  std::size_t camera = 0;
  std::size_t last_before = 0, first_after = 0;  // moments
  double shift_px = 0.0;                         // mean over the corners it saw afterwards
  double certainty = 0.0;                        // Fisher's F, a pose for each stretch against one for all views
  RigState after;                                // cameras as they stand afterwards; only this camera's differs
};
// `sightings` with outliers. Whether it moved is measured by how much its views disagree without any knock: what poses
// of their own would take off further, which holds the corners' noise as well as what lens and board model miss. Boards
// are posed by the other cameras, so a knocked neighbour shows here too: whose_knock (knock_trial.h) tells.
// Nothing if the camera stood still as far as can be told.
std::optional<Knock> find_knock(const RigState& state, std::span<const Sighting> sightings,
                                std::span<const Board> boards, std::size_t camera, double noise_px);
// "cam04 moved between m012 and m013, by 12.0 px", or, where it then shows what another showed, that they were swapped.
std::string in_words(const Knock& knock, const RigState& state, std::span<const std::string> moments);

}  // namespace rotunda::capture
