#pragma once
// What goes wrong in rigs, found and named: cameras that changed names or see no board together, a mirrored picture.
// Knocked cameras: camera_knock.h.
#include <string>

#include "capture/calibration/camera_graph.h"

namespace rotunda::capture {

// Why a group of cameras (graph.groups[group]) is apart from the first: no moment in common, or boards that agree on
// nothing (mirrored, out of step).
std::string why_apart(const CameraGraph& graph, std::size_t group, std::span<const CameraModel> cameras,
                      std::span<const Sighting> sightings, std::span<const Board> boards);

// Cameras that stand where the reference (cameras as they were, with poses) has another: names exchanged since.
std::vector<std::string> find_swaps(const RigState& state, std::span<const CameraModel> reference);

}  // namespace rotunda::capture
