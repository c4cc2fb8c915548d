#include "capture/calibration/world_frame.h"

#include <algorithm>

namespace rotunda::capture {
namespace {

constexpr double kBelow = 0.03;   // metres a corner may lie under the floor: a bent floor, a thick board
constexpr double kAbove = 0.10;   // metres a camera must stand over it
constexpr double kUpright = 0.7;  // cosine between the board's normal and the cameras' mean upwards

bool everything_is_above(const Eigen::Isometry3d& floor_from_world, const RigState& state,
                         std::span<const Board> boards) {
  for (const auto& camera : state.cameras)
    if ((floor_from_world * camera.centre()).z() < kAbove) return false;
  for (const auto& [key, pose] : state.world_from_board)
    for (const auto& corner : corner_positions(boards[key.second]))
      if ((floor_from_world * pose * corner).z() < -kBelow) return false;
  return true;
}

}  // namespace

std::optional<BoardKey> board_on_floor(const RigState& state, std::span<const Sighting> sightings,
                                       std::span<const Board> boards) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const auto& camera : state.cameras) up -= camera.R.row(1).transpose();
  if (up.norm() < 1e-9) return std::nullopt;
  up.normalize();
  std::optional<BoardKey> best;
  std::ptrdiff_t most = 0;
  for (const auto& [key, pose] : state.world_from_board) {
    if (pose.linear().col(2).dot(up) < kUpright || !everything_is_above(pose.inverse(), state, boards)) continue;
    const auto seen = std::count_if(sightings.begin(), sightings.end(), [&, k = key](const auto& sighting) {
      return sighting.moment == k.first && sighting.board == k.second;
    });
    if (seen <= most) continue;
    most = seen;
    best = key;
  }
  return best;
}

void move_world(RigState& state, const Eigen::Isometry3d& new_from_old) {
  const Eigen::Isometry3d old_from_new = new_from_old.inverse();
  for (auto& camera : state.cameras) {
    camera.t += camera.R * old_from_new.translation();
    camera.R = Eigen::Matrix3d(camera.R * old_from_new.linear());
  }
  for (auto& [key, pose] : state.world_from_board) pose = new_from_old * pose;
}

}  // namespace rotunda::capture
