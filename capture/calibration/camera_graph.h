#pragma once
// Which cameras see boards together, and from that where each stands: relative poses by pairs, chained along the ties
// that most boards agree on (a maximum spanning tree), then the boards' poses that suit all cameras best.
#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

struct SeenTogether {
  std::size_t a = 0, b = 0;
  int boards = 0;    // seen by both at one moment
  int agreeing = 0;  // of them, with one relative pose of the cameras
  Eigen::Isometry3d b_from_a = Eigen::Isometry3d::Identity();
};

struct CameraGraph {
  std::vector<SeenTogether> ties;                // pairs with at least one board in common
  std::vector<std::vector<std::size_t>> groups;  // of cameras tied together, the largest first; each ascending
  RigState state;                                // poses of the first group; the others' cameras are left as they were
  // Boards that look the same upside down, where a camera's corners are listed from the other end than the pose has it.
  std::vector<std::pair<std::size_t, BoardKey>> turned;
};

// `cameras` with intrinsics; their poses are not read.
CameraGraph place_cameras(std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                          std::span<const Board> boards);

// Whether the sighting lies about where the placed cameras and boards have it. `state` as place_cameras leaves it.
bool is_as_placed(const RigState& state, const Sighting& sighting, std::span<const Board> boards);

}  // namespace rotunda::capture
