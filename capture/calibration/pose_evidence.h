#pragma once
// What a camera's views of boards say about the camera's pose, each alone and some together, to first order: whether
// one pose does for all of them, or it takes one before and another after some moment.
#include <Eigen/Core>
#include <span>
#include <vector>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

using Pose6 = Eigen::Matrix<double, 6, 1>;  // a turn and a shift of the camera in its own frame; radians, metres
using Matrix6 = Eigen::Matrix<double, 6, 6>;
CameraModel moved(CameraModel camera, const Pose6& by);

inline constexpr std::size_t kFewestStretch = 2;  // views before and after

// One view of the camera with what its corners say about the camera's pose: normal equations, pixels.
struct PoseEvidence {
  std::size_t moment = 0;
  Eigen::Vector3d board = Eigen::Vector3d::Zero();  // its middle
  Matrix6 H = Matrix6::Zero();
  Pose6 g = Pose6::Zero();
};

PoseEvidence evidence_of(const RigState& state, const Sighting& sighting, const Board& board);
PoseEvidence sum_of(std::span<const PoseEvidence> all);
// The pose that fits best, from where the camera stands.
Pose6 solution(const PoseEvidence& evidence);

// The views after which a pose of its own for what follows helps most; 0: none. Ascending moments.
std::size_t best_split(const std::vector<PoseEvidence>& views);
// Fisher's F of two poses against one, without the boards of any one place, whichever matters most: boards in one place
// are off by the same, and would pass for so many witnesses.
double certainty_without_any_place(const std::vector<PoseEvidence>& views, std::size_t split, double noise_px);

}  // namespace rotunda::capture
