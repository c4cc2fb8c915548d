#include "capture/calibration/pose_evidence.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <limits>

#include "config/median.h"

namespace rotunda::capture {
namespace {

constexpr double kOtherPlace = 0.10;      // metres: boards nearer to each other stand in one place
constexpr double kOtherCornersOff = 5.0;  // pixels from the view's median: a wrong corner, not a knock

// What a pose of its own takes off the stretch's squares.
double gain(const PoseEvidence& evidence) {
  return evidence.g.dot(solution(evidence));
}

// What a stretch's own pose leaves that poses of the views' own would take off further.
double disagreement(std::span<const PoseEvidence> views) {
  const Pose6 x = solution(sum_of(views));
  double sum = 0.0;
  for (const auto& view : views) {
    PoseEvidence rest = view;
    rest.g -= view.H * x;
    sum += gain(rest);
  }
  return sum;
}

// Fisher's F of two poses against one, views being what is drawn at random: six numbers a pose.
double certainty_of(const std::vector<PoseEvidence>& views, std::size_t split, double noise_px) {
  const std::span all(views);
  const double helps = gain(sum_of(all.first(split))) + gain(sum_of(all.subspan(split))) - gain(sum_of(all));
  const double freedom = static_cast<double>(views.size() - 2);
  const double scatter = (disagreement(all.first(split)) + disagreement(all.subspan(split))) / freedom;
  return helps / std::max(scatter, 6.0 * noise_px * noise_px);
}

}  // namespace

CameraModel moved(CameraModel camera, const Pose6& by) {
  const Eigen::Vector3d axis = by.head<3>();
  if (axis.norm() > 0.0) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
    camera.R = Eigen::Matrix3d(turn * camera.R);
    camera.t = Eigen::Vector3d(turn * camera.t);
  }
  camera.t += by.tail<3>();
  return camera;
}

PoseEvidence evidence_of(const RigState& state, const Sighting& sighting, const Board& board) {
  PoseEvidence evidence{.moment = sighting.moment,
                        .board = state.world_from_board.at({sighting.moment, sighting.board}).translation()};
  const auto positions = corner_positions(board);
  const auto& world_from_board = state.world_from_board.at({sighting.moment, sighting.board});
  std::vector<double> across, down;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector3d>> offs;
  for (const auto& corner : sighting.corners) {
    const auto& at = positions[static_cast<std::size_t>(corner.corner)];
    const auto off = residual(state, sighting, corner, at);
    if (!off) continue;
    offs.emplace_back(*off, world_from_board * at);
    across.push_back(off->x()), down.push_back(off->y());
  }
  const Eigen::Vector2d middle(median(across), median(down));
  constexpr double kStep = 1e-6;
  for (const auto& [off, world] : offs) {
    if ((off - middle).norm() > kOtherCornersOff) continue;
    Eigen::Matrix<double, 2, 6> J;
    for (int i = 0; i < 6; ++i) {
      const auto up = project(moved(state.cameras[sighting.camera], kStep * Pose6::Unit(i)), world);
      const auto low = project(moved(state.cameras[sighting.camera], -kStep * Pose6::Unit(i)), world);
      J.col(i) = up && low ? Eigen::Vector2d((*up - *low) / (2.0 * kStep)) : Eigen::Vector2d(Eigen::Vector2d::Zero());
    }
    evidence.H += J.transpose() * J;
    evidence.g += J.transpose() * off;
  }
  return evidence;
}

PoseEvidence sum_of(std::span<const PoseEvidence> all) {
  PoseEvidence sum;
  for (const auto& one : all) sum.H += one.H, sum.g += one.g;
  return sum;
}

Pose6 solution(const PoseEvidence& evidence) {
  const Matrix6 damped = evidence.H + 1e-9 * evidence.H.trace() * Matrix6::Identity();
  return damped.ldlt().solve(evidence.g);
}

std::size_t best_split(const std::vector<PoseEvidence>& views) {
  std::size_t best = 0;
  double most = 0.0;
  for (std::size_t i = kFewestStretch; i + kFewestStretch <= views.size(); ++i) {
    if (views[i].moment == views[i - 1].moment) continue;
    const double helps = gain(sum_of(std::span(views).first(i))) + gain(sum_of(std::span(views).subspan(i)));
    if (helps <= most) continue;
    most = helps;
    best = i;
  }
  return best;
}

double certainty_without_any_place(const std::vector<PoseEvidence>& views, std::size_t split, double noise_px) {
  const std::size_t first_after = views[split].moment;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& left_out : views) {
    std::vector<PoseEvidence> rest;
    std::copy_if(views.begin(), views.end(), std::back_inserter(rest),
                 [&](const auto& view) { return (view.board - left_out.board).norm() > kOtherPlace; });
    const auto before = static_cast<std::size_t>(
        std::count_if(rest.begin(), rest.end(), [&](const auto& view) { return view.moment < first_after; }));
    if (rest.size() < 3 || before == 0 || before == rest.size()) return 0.0;
    least = std::min(least, certainty_of(rest, before, noise_px));
  }
  return least;
}

}  // namespace rotunda::capture
