#include "capture/calibration/calibration_quality.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "capture/calibration/calibration_covariance.h"

namespace rotunda::capture {
namespace {

constexpr std::size_t kHeldOutEvery = 6, kFewestForHoldingOut = 8;

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double percentile95(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<long>(values.size() * 95 / 100);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

CalibratedView view_of(const RigState& state, const Sighting& sighting, const Board& board, double outlier_px) {
  CalibratedView view{
      .camera = sighting.camera, .moment = sighting.moment, .board = sighting.board, .predicted = sighting.predicted};
  const auto positions = corner_positions(board);
  std::vector<double> distances;
  for (const auto& corner : sighting.corners) {
    const auto off = residual(state, sighting, corner, positions[static_cast<std::size_t>(corner.corner)]);
    const bool outlier = !off || off->norm() > outlier_px;
    view.corners.push_back({corner.corner, corner.pixel, off.value_or(Eigen::Vector2d::Zero()), outlier});
    if (!outlier) distances.push_back(off->norm());
  }
  view.rms_px = root_mean_square(distances);
  return view;
}

// Moments that tell something about how the cameras stand: a board seen by two.
std::vector<std::size_t> shared_moments(std::span<const Sighting> sightings) {
  std::map<BoardKey, std::set<std::size_t>> cameras;
  for (const auto& sighting : sightings) cameras[{sighting.moment, sighting.board}].insert(sighting.camera);
  std::set<std::size_t> moments;
  for (const auto& [key, seen_by] : cameras)
    if (seen_by.size() >= 2) moments.insert(key.first);
  return {moments.begin(), moments.end()};
}

std::vector<std::vector<double>> distances_by_camera(const RigState& state, std::span<const Sighting> sightings,
                                                     std::span<const Board> boards) {
  std::vector<std::vector<double>> distances(state.cameras.size());
  for (const auto& sighting : sightings) {
    if (!state.world_from_board.contains({sighting.moment, sighting.board})) continue;
    const auto positions = corner_positions(boards[sighting.board]);
    for (const auto& corner : sighting.corners)
      if (const auto off = residual(state, sighting, corner, positions[static_cast<std::size_t>(corner.corner)]))
        distances[sighting.camera].push_back(off->norm());
  }
  return distances;
}

using KeptAndOut = std::pair<std::vector<Sighting>, std::vector<Sighting>>;

KeptAndOut without_moments(std::span<const Sighting> sightings, const std::set<std::size_t>& held_out) {
  KeptAndOut parts;
  for (const auto& sighting : sightings)
    (held_out.contains(sighting.moment) ? parts.second : parts.first).push_back(sighting);
  return parts;
}

// Where there are too few moments to spare any: a fifth of each board's corners, a knight's move apart.
KeptAndOut without_some_corners(std::span<const Sighting> sightings, std::span<const Board> boards) {
  KeptAndOut parts;
  for (const auto& sighting : sightings) {
    const int columns = boards[sighting.board].columns - 1;
    Sighting kept = sighting, out = sighting;
    const auto is_out = [&](const auto& found) {
      return (found.corner % columns + 2 * (found.corner / columns)) % 5 == 2;
    };
    std::erase_if(kept.corners, is_out);
    std::erase_if(out.corners, std::not_fn(is_out));
    parts.first.push_back(std::move(kept));
    parts.second.push_back(std::move(out));
  }
  return parts;
}

double farthest_corner_of_picture(const CameraModel& camera) {
  double farthest = 0.0;
  for (const double x : {0.0, camera.width - 1.0})
    for (const double y : {0.0, camera.height - 1.0})
      farthest = std::max(farthest, std::hypot(x - camera.K(0, 2), y - camera.K(1, 2)));
  return farthest;
}

void add_to_coverage(const CameraModel& camera, const Eigen::Vector2d& pixel, ImageCoverage& coverage) {
  const auto cell = [](double at, int size, int cells) {
    return std::clamp(static_cast<int>((at + 0.5) / size * cells), 0, cells - 1);
  };
  const int x = cell(pixel.x(), camera.width, coverage.columns), y = cell(pixel.y(), camera.height, coverage.rows);
  ++coverage.corners[static_cast<std::size_t>(y * coverage.columns + x)];
  const double radius = std::hypot(pixel.x() - camera.K(0, 2), pixel.y() - camera.K(1, 2));
  coverage.outermost_radius = std::max(coverage.outermost_radius, radius / farthest_corner_of_picture(camera));
}

void fill_volume(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                 VolumeCoverage& volume) {
  for (const auto& [key, pose] : state.world_from_board)
    for (const auto& corner : corner_positions(boards[key.second])) volume.box.extend(pose * corner);
  std::vector<std::set<std::size_t>> seen_by(static_cast<std::size_t>(volume.cells.prod()));
  volume.views.assign(seen_by.size(), 0);
  for (const auto& sighting : sightings) {
    const auto pose = state.world_from_board.find({sighting.moment, sighting.board});
    if (pose == state.world_from_board.end()) continue;
    const auto positions = corner_positions(boards[sighting.board]);
    for (const auto& corner : sighting.corners) {
      const Eigen::Array3d share =
          (pose->second * positions[static_cast<std::size_t>(corner.corner)] - volume.box.min()).array() /
          volume.box.sizes().array().max(1e-9);
      const Eigen::Array3i cell =
          (share * volume.cells.cast<double>()).cast<int>().min(volume.cells - 1).max(Eigen::Array3i::Zero());
      const auto at = static_cast<std::size_t>((cell.z() * volume.cells.y() + cell.y()) * volume.cells.x() + cell.x());
      ++volume.views[at];
      seen_by[at].insert(sighting.camera);
    }
  }
  const auto well = std::count_if(seen_by.begin(), seen_by.end(), [](const auto& by) { return by.size() >= 2; });
  volume.share = static_cast<double>(well) / static_cast<double>(seen_by.size());
}

// At the depth where boards were.
std::vector<Eigen::Vector3d> seen_at_rim(const CameraModel& camera, const ImageCoverage& coverage) {
  constexpr int kSteps = 6;  // a side
  const double right = camera.width - 1.0, bottom = camera.height - 1.0;
  const double away = 0.5 * (coverage.nearest + coverage.farthest);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kSteps; ++i) {
    const double x = right * i / kSteps, y = bottom * i / kSteps;
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(x, 0.0), Eigen::Vector2d(right, y),
                                         Eigen::Vector2d(right - x, bottom), Eigen::Vector2d(0.0, bottom - y)})
      if (const auto ray = ray_through(camera, pixel)) points.push_back(camera.centre() + away * *ray);
  }
  return points;
}

}  // namespace

void tell_residuals(const RigState& state, std::span<const Sighting> with_outliers, std::span<const Board> boards,
                    double outlier_px, CalibrationResult& result) {
  result.quality.resize(state.cameras.size());
  std::vector<std::vector<double>> distances(state.cameras.size());
  std::vector<double> all;
  for (const auto& sighting : with_outliers) {
    if (!state.world_from_board.contains({sighting.moment, sighting.board})) continue;
    auto view = view_of(state, sighting, boards[sighting.board], outlier_px);
    auto& quality = result.quality[sighting.camera];
    ++quality.views;
    for (const auto& corner : view.corners) {
      corner.outlier ? ++quality.outliers : ++quality.corners;
      if (corner.outlier) continue;
      distances[sighting.camera].push_back(corner.off.norm());
      all.push_back(corner.off.norm());
    }
    result.views.push_back(std::move(view));
  }
  for (std::size_t i = 0; i < distances.size(); ++i) {
    auto& quality = result.quality[i];
    quality.rms_px = root_mean_square(distances[i]);
    quality.p95_px = percentile95(distances[i]);
    result.corners += quality.corners;
    result.outliers += quality.outliers;
  }
  result.rms_px = root_mean_square(all);
  result.p95_px = percentile95(all);
}

void tell_held_out(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                   const AdjustmentOptions& options, CalibrationResult& result) {
  const auto moments = shared_moments(sightings);
  const bool by_moment = moments.size() >= kFewestForHoldingOut;
  std::set<std::size_t> held_out;
  for (std::size_t i = kHeldOutEvery / 2; by_moment && i < moments.size(); i += kHeldOutEvery)
    held_out.insert(moments[i]);
  auto [kept, out] = by_moment ? without_moments(sightings, held_out) : without_some_corners(sightings, boards);
  RigState trained = state;
  adjust(trained, kept, boards, options);
  auto only_boards = options;
  only_boards.keep_cameras = true;
  if (by_moment) adjust(trained, out, boards, only_boards);
  std::vector<double> all;
  const auto distances = distances_by_camera(trained, out, boards);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    result.quality[i].held_out_rms_px = root_mean_square(distances[i]);
    all.insert(all.end(), distances[i].begin(), distances[i].end());
  }
  result.held_out_rms_px = root_mean_square(all);
  result.held_out_moments = static_cast<int>(held_out.size());
}

void tell_coverage(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                   CalibrationResult& result) {
  for (auto& quality : result.quality)
    quality.coverage.corners.assign(static_cast<std::size_t>(quality.coverage.columns * quality.coverage.rows), 0);
  for (const auto& sighting : sightings) {
    auto& coverage = result.quality[sighting.camera].coverage;
    const auto& camera = state.cameras[sighting.camera];
    for (const auto& corner : sighting.corners) add_to_coverage(camera, corner.pixel, coverage);
    const auto pose = state.world_from_board.find({sighting.moment, sighting.board});
    if (pose == state.world_from_board.end()) continue;
    const double away = (pose->second.translation() - camera.centre()).norm();
    coverage.nearest = coverage.nearest == 0.0 ? away : std::min(coverage.nearest, away);
    coverage.farthest = std::max(coverage.farthest, away);
  }
  fill_volume(state, sightings, boards, result.volume);
}

void tell_deviations(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                     const AdjustmentOptions& options, CalibrationResult& result) {
  const auto covariance = camera_covariance(state, sightings, boards, options, result.corner_noise_px);
  for (std::size_t i = 0; i < state.cameras.size(); ++i) {
    auto& quality = result.quality[i];
    quality.deviation = deviation_of(covariance, i);
    quality.deviation.rim_px =
        expected_reprojection(covariance, state, i, seen_at_rim(state.cameras[i], quality.coverage));
  }
  std::map<BoardKey, std::vector<std::size_t>> seen_by;
  for (const auto& sighting : sightings) seen_by[{sighting.moment, sighting.board}].push_back(sighting.camera);
  std::map<std::pair<std::size_t, std::size_t>, std::set<std::size_t>> together;
  for (const auto& [key, cameras] : seen_by)
    for (const std::size_t a : cameras)
      for (const std::size_t b : cameras)
        if (a < b) together[{a, b}].insert(key.first);
  for (const auto& [pair, moments] : together) {
    const auto [a, b] = pair;
    result.ties.push_back({a, b, static_cast<int>(moments.size()),
                           (state.cameras[a].centre() - state.cameras[b].centre()).norm(),
                           baseline_deviation(covariance, state, a, b)});
  }
}

}  // namespace rotunda::capture
