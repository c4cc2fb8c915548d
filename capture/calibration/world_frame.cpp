#include "capture/calibration/world_frame.h"

#include <fmt/format.h>

#include <algorithm>

#include "config/errors.h"

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

Eigen::Isometry3d camera_from_world(const CameraModel& camera) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = camera.R;
  pose.translation() = camera.t;
  return pose;
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

WorldFrame take_world_frame(RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                            std::span<const std::string> moments, const std::string& world_from) {
  if (!world_from.empty()) {
    const auto camera =
        std::find_if(state.cameras.begin(), state.cameras.end(), [&](const auto& c) { return c.name == world_from; });
    if (camera == state.cameras.end())
      throw InvalidInput(
          fmt::format("the world cannot be taken from {}: it is not among the calibrated cameras", world_from));
    move_world(state, camera_from_world(*camera));
    return {.where = "the frame of " + world_from, .advice = {}};
  }
  if (const auto floor = board_on_floor(state, sightings, boards)) {
    move_world(state, state.world_from_board.at(*floor).inverse());
    return {.where = fmt::format("the board on the floor at {}: origin at its middle, x along it, z up",
                                 moments[floor->first]),
            .advice = {}};
  }
  move_world(state, camera_from_world(state.cameras.front()));
  return {.where = fmt::format("the frame of {}, as no board lay on the floor", state.cameras.front().name),
          .advice = "lay the board on the floor, face up, for one moment: it gives the world its origin and its floor"};
}

}  // namespace rotunda::capture
