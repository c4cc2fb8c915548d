#pragma once
// How sure the adjustment is of what it found: the covariance of all cameras, board poses eliminated, in the frame that
// all camera centres hold together (inner constraints; Baarda's S-transformation), which is that of a rigid alignment.
#include <Eigen/Core>

#include "capture/calibration/bundle_adjustment.h"
#include "capture/calibration/calibration_result.h"

namespace rotunda::capture {

inline constexpr int kCameraUnknowns = 15;  // fx fy cx cy k1 k2 p1 p2 k3, rotation in world (rad), centre (m)

// A square matrix, kCameraUnknowns a camera; zero for cameras without sightings and for intrinsics that were kept.
// Empty if the equations do not determine the rig.
Eigen::MatrixXd camera_covariance(const RigState& state, std::span<const Sighting> sightings,
                                  std::span<const Board> boards, const AdjustmentOptions& options, double noise_px);

CameraDeviation deviation_of(const Eigen::MatrixXd& covariance, std::size_t camera);
// Standard deviation of the distance between two cameras, metres.
double baseline_deviation(const Eigen::MatrixXd& covariance, const RigState& state, std::size_t a, std::size_t b);
// Root mean square distance in pixels by which a world point's projection is expected to be off.
double expected_reprojection(const Eigen::MatrixXd& covariance, const RigState& state, std::size_t camera,
                             std::span<const Eigen::Vector3d> points);

}  // namespace rotunda::capture
