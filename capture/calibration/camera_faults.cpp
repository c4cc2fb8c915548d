#include "capture/calibration/camera_faults.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "capture/calibration/camera_exchange.h"

namespace rotunda::capture {
namespace {

constexpr double kSamePlace = 0.15;  // metres

std::vector<std::string> names_exchanged(const RigState& state, std::span<const CameraModel> reference) {
  const auto n = static_cast<Eigen::Index>(state.cameras.size());
  Eigen::Matrix3Xd now(3, n), then(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& camera = state.cameras[static_cast<std::size_t>(i)];
    const auto known =
        std::find_if(reference.begin(), reference.end(), [&](const auto& other) { return other.name == camera.name; });
    if (known == reference.end()) return {};
    now.col(i) = camera.centre();
    then.col(i) = known->centre();
  }
  if ((then.colwise() - then.col(0)).norm() < kSamePlace) return {};  // the reference has no poses
  std::vector<std::string> faults;
  while (const auto swapped = exchanged_centres(now, then)) {
    then.col(swapped->first).swap(then.col(swapped->second));
    faults.push_back(
        fmt::format("{} and {} are swapped: each stands where the given file has the other; exchange their "
                    "cables, names or folders",
                    state.cameras[static_cast<std::size_t>(swapped->first)].name,
                    state.cameras[static_cast<std::size_t>(swapped->second)].name));
  }
  return faults;
}

// The board as it would be listed were the picture mirrored: OpenCV finds a chessboard either way.
Sighting mirrored(Sighting sighting, const CameraModel& camera, const Board& board) {
  const int columns = board.columns - 1, rows = board.rows - 1;
  for (auto& corner : sighting.corners) {
    const int column = corner.corner % columns, row = corner.corner / columns;
    // Of the two ways about, the one that keeps black squares black.
    corner.corner =
        board.columns % 2 == 1 ? row * columns + (columns - 1 - column) : (rows - 1 - row) * columns + column;
    corner.pixel.x() = camera.width - 1 - corner.pixel.x();
  }
  return sighting;
}

bool fits_mirrored(std::size_t camera, const std::vector<std::size_t>& group, std::span<const CameraModel> cameras,
                   std::span<const Sighting> sightings, std::span<const Board> boards) {
  std::vector<CameraModel> some{cameras[camera]};
  some.front().K(0, 2) = some.front().width - 1 - some.front().K(0, 2);
  for (const std::size_t other : group) some.push_back(cameras[other]);
  std::vector<Sighting> theirs;
  for (auto sighting : sightings) {
    const auto other = std::find(group.begin(), group.end(), sighting.camera);
    if (sighting.camera == camera) {
      sighting = mirrored(std::move(sighting), cameras[camera], boards[sighting.board]);
      sighting.camera = 0;
    } else if (other != group.end()) {
      sighting.camera = static_cast<std::size_t>(other - group.begin()) + 1;
    } else {
      continue;
    }
    theirs.push_back(std::move(sighting));
  }
  const auto graph = place_cameras(some, theirs, boards);
  return std::any_of(graph.ties.begin(), graph.ties.end(),
                     [](const auto& tie) { return tie.a == 0 && 2 * tie.agreeing > tie.boards; });
}

}  // namespace

std::string why_apart(const CameraGraph& graph, std::size_t group, std::span<const CameraModel> cameras,
                      std::span<const Sighting> sightings, std::span<const Board> boards) {
  const auto& apart = graph.groups[group];
  const auto& main = graph.groups.front();
  int shared = 0;
  for (const auto& tie : graph.ties)
    for (const auto& [one, other] : {std::pair{tie.a, tie.b}, {tie.b, tie.a}})
      if (std::count(apart.begin(), apart.end(), one) > 0 && std::count(main.begin(), main.end(), other) > 0)
        shared += tie.boards;
  std::string names = cameras[apart.front()].name;
  for (std::size_t i = 1; i < apart.size(); ++i) names += ", " + cameras[apart[i]].name;
  if (shared == 0)
    return fmt::format("{} never saw the board at the same moment as {}: left out", names, cameras[main.front()].name);
  if (boards[0].type == BoardType::chessboard && fits_mirrored(apart.front(), main, cameras, sightings, boards))
    return fmt::format("{}: its picture is mirrored; switch that off in the camera", names);
  return fmt::format(
      "{} saw the board {} times together with others, and each time it stands elsewhere: pictures of "
      "other moments, or a mirrored picture; left out",
      names, shared);
}

std::vector<std::string> find_swaps(const RigState& state, std::span<const CameraModel> reference) {
  return names_exchanged(state, reference);
}

}  // namespace rotunda::capture
