#include "capture/calibration/knock_trial.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace rotunda::capture {
namespace {

constexpr int kFewestViews = 2;   // before and after
constexpr double kOutlier = 3.0;  // noises: what is off further counts as this
constexpr int kRounds = 2;

struct Trial {
  Knock knock;
  double misfit = std::numeric_limits<double>::infinity();  // squared pixels, outliers cut off
};

// The moments of the camera's own views about the moment of the knock; `split` is none of them if it saw too little.
struct Stretches {
  std::size_t last_before = 0, first_after = 0;
  int before = 0, after = 0;
  bool enough() const { return before >= kFewestViews && after >= kFewestViews; }
};

Stretches stretches_of(std::span<const Sighting> sightings, std::size_t camera, std::size_t first_after) {
  Stretches found{.first_after = std::numeric_limits<std::size_t>::max()};
  for (const auto& sighting : sightings) {
    if (sighting.camera != camera) continue;
    if (sighting.moment < first_after) {
      ++found.before;
      found.last_before = std::max(found.last_before, sighting.moment);
    } else {
      ++found.after;
      found.first_after = std::min(found.first_after, sighting.moment);
    }
  }
  return found;
}

double misfit_of(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                 double noise_px) {
  const double most = kOutlier * kOutlier * 2.0 * noise_px * noise_px;  // of two axes
  double sum = 0.0;
  for (const auto& sighting : sightings) {
    if (!state.world_from_board.contains({sighting.moment, sighting.board})) continue;
    const auto positions = corner_positions(boards[sighting.board]);
    for (const auto& corner : sighting.corners) {
      const auto off = residual(state, sighting, corner, positions[static_cast<std::size_t>(corner.corner)]);
      sum += off ? std::min(off->squaredNorm(), most) : most;
    }
  }
  return sum;
}

// How far its corners are from each other as seen by either pose, in the views that come after.
double shift_px(const RigState& state, const CameraModel& before, const CameraModel& after, std::size_t camera,
                std::span<const Sighting> sightings, std::span<const Board> boards) {
  double sum = 0.0;
  int count = 0;
  for (const auto& sighting : sightings) {
    const auto pose = state.world_from_board.find({sighting.moment, sighting.board});
    if (sighting.camera != camera || pose == state.world_from_board.end()) continue;
    for (const auto& corner : corner_positions(boards[sighting.board])) {
      const auto a = project(before, pose->second * corner), b = project(after, pose->second * corner);
      if (!a || !b) continue;
      sum += (*a - *b).norm();
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// The camera as two: as it stood before and, numbered behind all others, afterwards.
Trial try_camera(std::size_t camera, std::size_t first_after, const RigState& state,
                 std::span<const Sighting> sightings, std::span<const Board> boards, double noise_px) {
  const auto stretches = stretches_of(sightings, camera, first_after);
  if (!stretches.enough()) return {};
  RigState rig = state;
  rig.cameras.push_back(state.cameras[camera]);
  const std::size_t afterwards = rig.cameras.size() - 1;
  std::vector<Sighting> theirs(sightings.begin(), sightings.end());
  for (auto& sighting : theirs)
    if (sighting.camera == camera && sighting.moment >= first_after) sighting.camera = afterwards;
  adjust(rig, theirs, boards, {.keep_intrinsics = true, .rounds = kRounds});
  Trial trial;
  trial.misfit = misfit_of(rig, theirs, boards, noise_px);
  trial.knock.camera = camera;
  trial.knock.last_before = stretches.last_before;
  trial.knock.first_after = stretches.first_after;
  trial.knock.shift_px = shift_px(rig, rig.cameras[camera], rig.cameras[afterwards], camera, sightings, boards);
  trial.knock.after = state;
  trial.knock.after.cameras[camera] = rig.cameras[afterwards];
  return trial;
}

}  // namespace

Knock whose_knock(const Knock& suspect, const RigState& state, std::span<const Sighting> sightings,
                  std::span<const Board> boards, double noise_px) {
  std::vector<Trial> trials(state.cameras.size());
  tbb::parallel_for(std::size_t{0}, trials.size(), [&](std::size_t camera) {
    trials[camera] = try_camera(camera, suspect.first_after, state, sightings, boards, noise_px);
  });
  const auto least =
      std::min_element(trials.begin(), trials.end(), [](const auto& a, const auto& b) { return a.misfit < b.misfit; });
  if (least->knock.camera == suspect.camera || least->knock.after.cameras.empty()) return suspect;
  least->knock.certainty = suspect.certainty;
  return std::move(least->knock);
}

}  // namespace rotunda::capture
