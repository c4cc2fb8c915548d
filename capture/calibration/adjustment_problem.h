#pragma once
// The bundle adjustment as Ceres has it, private to bundle_adjustment and calibration_covariance: parameter blocks, one
// residual block a corner, priors.
#include <ceres/problem.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "capture/calibration/bundle_adjustment.h"

namespace rotunda::capture {

inline constexpr std::size_t kIntrinsics = 9;  // fx fy cx cy k1 k2 p1 p2 k3
inline constexpr std::size_t kPose = 6;        // rotation vector, translation: target from source

struct CameraBlocks {
  std::array<double, kIntrinsics> intrinsics{};
  std::array<double, kPose> camera_from_world{};
};

class AdjustmentProblem {
 public:
  AdjustmentProblem(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                    const AdjustmentOptions& options, double noise_px);

  std::size_t corners() const { return corners_; }
  bool solve(double& cost);  // true if converged
  void write_to(RigState& state) const;

  ceres::Problem& problem() { return *problem_; }
  std::vector<CameraBlocks>& cameras() { return cameras_; }
  std::map<BoardKey, std::array<double, kPose>>& boards() { return boards_; }
  std::vector<std::array<double, 3>>& bends() { return bends_; }

 private:
  void add_corners(const Sighting& sighting, const Board& board, const CameraModel& camera);
  void add_priors(std::size_t camera, const CameraModel& model);
  void hold_what_is_kept(const AdjustmentOptions& options);

  double noise_px_;
  std::vector<CameraBlocks> cameras_;
  std::vector<int> seen_;  // corners a camera
  std::map<BoardKey, std::array<double, kPose>> boards_;
  std::vector<std::array<double, 3>> bends_;
  std::unique_ptr<ceres::Problem> problem_;
  std::size_t corners_ = 0;
};

}  // namespace rotunda::capture
