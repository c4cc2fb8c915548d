#include "capture/calibration/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/calibration/adjustment_problem.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kSmallestNoise = 1e-7;  // pixels; only rendered-by-formula corners come near
constexpr double kLargestNoise = 8.0;    // pixels: the first guess is never worse told than this
constexpr double kMedianOfNormal = 0.67449;

std::vector<double> absolute_residuals(const RigState& state, std::span<const Sighting> sightings,
                                       std::span<const Board> boards) {
  std::vector<double> all;
  for (const auto& sighting : sightings) {
    if (sighting.camera >= state.cameras.size() || !state.world_from_board.contains({sighting.moment, sighting.board}))
      continue;
    const auto positions = corner_positions(boards[sighting.board]);
    for (const auto& corner : sighting.corners)
      if (const auto off = residual(state, sighting, corner, positions[static_cast<std::size_t>(corner.corner)]))
        for (const double component : {off->x(), off->y()}) all.push_back(std::abs(component));
  }
  return all;
}

double clamped_noise(std::vector<double> residuals) {
  return std::clamp(noise_of(std::move(residuals)), kSmallestNoise, kLargestNoise);
}

}  // namespace

Eigen::Vector3d bent(const Bend& bend, const Eigen::Vector3d& flat) {
  return flat +
         Eigen::Vector3d(0, 0,
                         bend.xx * flat.x() * flat.x() + bend.xy * flat.x() * flat.y() + bend.yy * flat.y() * flat.y());
}

std::optional<Eigen::Vector2d> residual(const RigState& state, const Sighting& sighting, const FoundCorner& corner,
                                        const Eigen::Vector3d& on_board) {
  const auto& world_from_board = state.world_from_board.at({sighting.moment, sighting.board});
  const Bend bend = sighting.board < state.bends.size() ? state.bends[sighting.board] : Bend{};
  const auto pixel = project(state.cameras[sighting.camera], world_from_board * bent(bend, on_board));
  if (!pixel) return std::nullopt;
  return corner.pixel - *pixel;
}

double noise_of(std::vector<double> components) {
  if (components.empty()) return 0.0;
  const auto middle = components.begin() + static_cast<long>(components.size() / 2);
  std::nth_element(components.begin(), middle, components.end());
  return *middle / kMedianOfNormal;
}

std::vector<Sighting> without_outliers(const RigState& state, std::span<const Sighting> sightings,
                                       std::span<const Board> boards, double limit_px, std::size_t& removed) {
  std::vector<Sighting> kept;
  removed = 0;
  for (auto sighting : sightings) {
    const std::size_t before = sighting.corners.size();
    if (state.world_from_board.contains({sighting.moment, sighting.board})) {
      const auto positions = corner_positions(boards[sighting.board]);
      std::erase_if(sighting.corners, [&](const auto& corner) {
        const auto off = residual(state, sighting, corner, positions[static_cast<std::size_t>(corner.corner)]);
        return !off || off->norm() > limit_px;
      });
    }
    if (!span_an_area(sighting.corners, boards[sighting.board])) sighting.corners.clear();
    removed += before - sighting.corners.size();
    if (!sighting.corners.empty()) kept.push_back(std::move(sighting));
  }
  return kept;
}

AdjustmentReport adjust(RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                        const AdjustmentOptions& options) {
  if (state.cameras.empty()) throw InvalidInput("there is no camera to adjust");
  state.bends.resize(boards.size());
  AdjustmentReport report;
  report.noise_px = clamped_noise(absolute_residuals(state, sightings, boards));
  for (int round = 0; round < options.rounds; ++round) {
    AdjustmentProblem problem(state, sightings, boards, options, report.noise_px);
    if (problem.corners() == 0) throw InvalidInput("no board is seen by a camera of the calibration");
    report.corners = problem.corners();
    report.converged = problem.solve(report.cost);
    problem.write_to(state);
    const double noise = clamped_noise(absolute_residuals(state, sightings, boards));
    const bool settled = std::abs(noise - report.noise_px) <= 0.02 * report.noise_px;
    report.noise_px = noise;
    if (settled) break;
  }
  return report;
}

}  // namespace rotunda::capture
