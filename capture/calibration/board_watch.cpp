#include "capture/calibration/board_watch.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "capture/calibration/camera_start.h"

namespace rotunda::capture {
namespace {

using Cameras = std::vector<std::size_t>;  // numbers, rising

constexpr double kFarOff = 20.0;  // pixels: a corner farther off says no more against a pose than this

Eigen::Isometry3d world_from_camera(const CameraModel& camera) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = camera.R;
  pose.translation() = camera.t;
  return pose.inverse();
}

bool holds(const Cameras& cameras, std::size_t camera) {
  return std::binary_search(cameras.begin(), cameras.end(), camera);
}

Cameras without(Cameras cameras, std::size_t camera) {
  std::erase(cameras, camera);
  return cameras;
}

struct Misfit {
  double squares = 0.0;
  int corners = 0;
  double rms() const { return corners > 0 ? std::sqrt(squares / corners) : 0.0; }
};

class BoardWatch {
 public:
  BoardWatch(std::span<const CameraModel> cameras, std::span<const Sighting> sightings, std::span<const Board> boards)
      : cameras_(cameras), sightings_(sightings), boards_(boards) {}

  // How far a camera's corners are from where these others put the boards.
  Misfit from_others(std::size_t camera, const Cameras& others) const {
    const RigState posed = posed_by(without(others, camera), 1);
    return misfit_in(posed, camera);
  }

  // What is left when these pose together the boards that two of them or more saw.
  Misfit among(const Cameras& some) const {
    const RigState posed = posed_by(some, 2);
    Misfit sum;
    for (const auto camera : some) {
      const auto own = misfit_in(posed, camera);
      sum.squares += own.squares, sum.corners += own.corners;
    }
    return sum;
  }

 private:
  Misfit misfit_in(const RigState& posed, std::size_t camera) const {
    Misfit misfit;
    for (const auto& sighting : sightings_)
      if (sighting.camera == camera) add(posed, sighting, std::numeric_limits<double>::infinity(), misfit);
    return misfit;
  }

  void add(const RigState& posed, const Sighting& sighting, double most_px, Misfit& misfit) const {
    if (!posed.world_from_board.contains({sighting.moment, sighting.board})) return;
    const auto positions = corner_positions(boards_[sighting.board]);
    for (const auto& corner : sighting.corners)
      if (const auto off = residual(posed, sighting, corner, positions[static_cast<std::size_t>(corner.corner)])) {
        misfit.squares += std::min(off->squaredNorm(), most_px * most_px);
        ++misfit.corners;
      }
  }

  // The boards that so many of these cameras saw, posed by them alone.
  RigState posed_by(const Cameras& posing, std::size_t least_views) const {
    std::map<BoardKey, std::vector<const Sighting*>> views;
    for (const auto& sighting : sightings_)
      if (holds(posing, sighting.camera)) views[{sighting.moment, sighting.board}].push_back(&sighting);
    std::erase_if(views, [&](const auto& one) { return one.second.size() < least_views; });
    RigState state;
    state.cameras.assign(cameras_.begin(), cameras_.end());
    state.bends.resize(boards_.size());
    std::vector<Sighting> used;
    for (const auto& [key, seen] : views) {
      const auto pose = first_pose(state, key, seen);
      if (!pose) continue;
      state.world_from_board[key] = *pose;
      for (const auto* view : seen) used.push_back(*view);
    }
    if (!used.empty()) adjust(state, used, boards_, {.keep_cameras = true, .rounds = 2});
    return state;
  }

  // A plane has two poses in one camera, nearly alike: the other cameras tell which.
  std::optional<Eigen::Isometry3d> first_pose(RigState& state, const BoardKey& key,
                                              const std::vector<const Sighting*>& seen) const {
    std::optional<Eigen::Isometry3d> best;
    double least = std::numeric_limits<double>::infinity();
    for (const auto* view : seen)
      for (const auto& pose : camera_from_board(cameras_[view->camera], *view, boards_[view->board])) {
        state.world_from_board[key] = world_from_camera(cameras_[view->camera]) * pose;
        Misfit misfit;
        for (const auto* other : seen) add(state, *other, kFarOff, misfit);
        if (misfit.squares >= least) continue;
        least = misfit.squares;
        best = state.world_from_board[key];
      }
    state.world_from_board.erase(key);
    return best;
  }

  std::span<const CameraModel> cameras_;
  std::span<const Sighting> sightings_;
  std::span<const Board> boards_;
};

std::vector<Misfit> from_others(const BoardWatch& watch, std::size_t cameras, const Cameras& standing) {
  std::vector<Misfit> misfits(cameras);
  tbb::parallel_for(std::size_t{0}, cameras,
                    [&](std::size_t camera) { misfits[camera] = watch.from_others(camera, standing); });
  return misfits;
}

// Of those under suspicion the one without which the rest agrees best.
std::size_t least_fitting(const BoardWatch& watch, const Cameras& standing, const Cameras& suspects) {
  std::vector<double> left(suspects.size());
  tbb::parallel_for(std::size_t{0}, suspects.size(), [&](std::size_t i) {
    const auto rest = watch.among(without(standing, suspects[i]));
    left[i] = rest.corners > 0 ? rest.rms() : std::numeric_limits<double>::infinity();
  });
  return suspects[static_cast<std::size_t>(std::min_element(left.begin(), left.end()) - left.begin())];
}

Cameras told(const std::vector<Misfit>& misfits, const Cameras& of, double limit) {
  Cameras some;
  for (const auto camera : of)
    if (misfits[camera].rms() > limit) some.push_back(camera);
  return some;
}

Cameras with_corners(const std::vector<Misfit>& misfits) {
  Cameras some;
  for (std::size_t i = 0; i < misfits.size(); ++i)
    if (misfits[i].corners > 0) some.push_back(i);
  return some;
}

}  // namespace

std::vector<BoardShift> board_shifts(std::span<const CameraModel> cameras, std::span<const Sighting> sightings,
                                     std::span<const Board> boards, const BoardWatchOptions& options) {
  const BoardWatch watch(cameras, sightings, boards);
  Cameras all(cameras.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  auto misfits = from_others(watch, cameras.size(), all);
  Cameras standing = with_corners(misfits), suspects = told(misfits, standing, options.told_px);
  bool settled = suspects.empty();
  while (!settled && standing.size() > 2) {
    standing = without(standing, least_fitting(watch, standing, suspects));
    misfits = from_others(watch, cameras.size(), standing);
    suspects = told(misfits, standing, options.told_px);
    // Of the last two, the shift from one to the other is mostly the doubt in how far off one alone puts a board.
    settled = suspects.empty() || (standing.size() == 2 && watch.among(standing).rms() <= options.agree_px);
  }
  std::vector<BoardShift> shifts(cameras.size());
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const bool stands = holds(standing, i);
    shifts[i] = {.corners = misfits[i].corners, .shift_px = misfits[i].rms()};
    shifts[i].disputed = stands && !settled;
    shifts[i].moved = stands ? !settled : misfits[i].rms() > options.told_px;
  }
  return shifts;
}

}  // namespace rotunda::capture
