#pragma once
// A first calibration of one camera, from its own sightings alone: Zhang's closed form (2000) and, where its focal
// length is doubtful (boards all face the camera), a few others, each adjusted; the best is kept.
#include <optional>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

inline constexpr std::size_t kFewestViews = 3;  // that tell a lens; from fewer it is mostly what lenses are like

struct CameraStart {
  CameraModel camera;     // at the origin of its own frame
  double noise_px = 0.0;  // as far as its own boards can tell
};

// `camera`: name and size filled; the sightings are all of this camera's. Nothing with fewer than `fewest`.
std::optional<CameraStart> start_camera(const CameraModel& camera, std::span<const Sighting> sightings,
                                        std::span<const Board> boards, std::size_t fewest = kFewestViews);

// The board's poses in the camera that explain one sighting: a plane has two, nearly alike where it is small or far
// (Schweighofer, Pinz 2006); the better first. Empty if there is none.
std::vector<Eigen::Isometry3d> camera_from_board(const CameraModel& camera, const Sighting& sighting,
                                                 const Board& board);

}  // namespace rotunda::capture
