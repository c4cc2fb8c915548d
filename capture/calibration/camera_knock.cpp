#include "capture/calibration/camera_knock.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "capture/calibration/pose_evidence.h"
#include "config/median.h"

namespace rotunda::capture {
namespace {

constexpr double kDisturbed = 2.0;   // noises, a view's median: worth a closer look
constexpr double kLeastShift = 3.0;  // noises: less is in the residuals anyway
// F(6, 6 n) of no knock passes 6 once in 10^4 with five views, 10^5 with ten; a split is tried between any two.
constexpr double kCertain = 10.0;
constexpr double kLeastKnock = 0.25;  // pixels: less is no knock, but what a board in motion misses
constexpr double kOutlier = 3.0;      // noises: what is off further counts as this
constexpr int kRounds = 2;
constexpr std::size_t kFewViews = 12;       // a camera: with more, a knock shows
constexpr double kNumbersOfACamera = 15.0;  // a pose and a lens

// The boards of this camera that others see too, posed by the others alone.
RigState posed_by_others(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                         std::size_t camera) {
  std::set<BoardKey> own;
  for (const auto& sighting : sightings)
    if (sighting.camera == camera) own.insert({sighting.moment, sighting.board});
  std::vector<Sighting> others;
  RigState posed = state;
  posed.world_from_board.clear();
  for (const auto& sighting : sightings) {
    const BoardKey key{sighting.moment, sighting.board};
    const auto pose = state.world_from_board.find(key);
    if (sighting.camera == camera || !own.contains(key) || pose == state.world_from_board.end()) continue;
    posed.world_from_board[key] = pose->second;
    others.push_back(sighting);
  }
  if (!others.empty()) adjust(posed, others, boards, {.keep_cameras = true, .rounds = 1});
  return posed;
}

std::vector<const Sighting*> views_of(const RigState& state, std::span<const Sighting> sightings, std::size_t camera) {
  std::vector<const Sighting*> views;
  for (const auto& sighting : sightings)
    if (sighting.camera == camera && state.world_from_board.contains({sighting.moment, sighting.board}))
      views.push_back(&sighting);
  std::stable_sort(views.begin(), views.end(), [](const auto* a, const auto* b) { return a->moment < b->moment; });
  return views;
}

std::vector<PoseEvidence> evidence_of(const RigState& state, std::span<const Sighting* const> views,
                                      std::span<const Board> boards) {
  std::vector<PoseEvidence> all;
  for (const auto* view : views) all.push_back(evidence_of(state, *view, boards[view->board]));
  return all;
}

bool looks_disturbed(const RigState& state, std::span<const Sighting* const> views, std::span<const Board> boards,
                     double limit) {
  std::size_t far_off = 0;
  for (const auto* view : views) {
    const auto positions = corner_positions(boards[view->board]);
    std::vector<double> distances;
    for (const auto& corner : view->corners)
      if (const auto off = residual(state, *view, corner, positions[static_cast<std::size_t>(corner.corner)]))
        distances.push_back(off->norm());
    if (median(distances) > limit) ++far_off;
  }
  return far_off >= kFewestStretch;
}

// The camera's pose by some views alone, boards held (Gauss-Newton).
CameraModel resected(RigState state, std::span<const Sighting* const> views, std::span<const Board> boards,
                     std::size_t camera) {
  for (int i = 0; i < 10; ++i)
    state.cameras[camera] = moved(state.cameras[camera], solution(sum_of(evidence_of(state, views, boards))));
  return state.cameras[camera];
}

// Between which moments this camera's views stop to agree, and how surely.
struct Suspicion {
  std::size_t first_after = 0;  // moment
  double certainty = 0.0;       // Fisher's F, a pose for each stretch against one for all views; 0: none
};

Suspicion suspicion_of(const RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                       std::size_t camera, double noise_px) {
  if (!looks_disturbed(state, views_of(state, sightings, camera), boards, kDisturbed * noise_px)) return {};
  const RigState posed = posed_by_others(state, sightings, boards, camera);
  const auto evidence = evidence_of(posed, views_of(posed, sightings, camera), boards);
  const std::size_t split = best_split(evidence);
  if (split == 0) return {};
  return {evidence[split].moment, certainty_without_any_place(evidence, split, noise_px)};
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

// The mean over its views of how far apart the corners are that two poses of a camera see.
double mean_shift(const RigState& state, const CameraModel& before, const CameraModel& after,
                  std::span<const Sighting* const> views, std::span<const Board> boards) {
  double sum = 0.0;
  int count = 0;
  for (const auto* view : views)
    for (const auto& corner : corner_positions(boards[view->board])) {
      const Eigen::Vector3d world = state.world_from_board.at({view->moment, view->board}) * corner;
      const auto a = project(before, world), b = project(after, world);
      if (!a || !b) continue;
      sum += (*a - *b).norm();
      ++count;
    }
  return count > 0 ? sum / count : 0.0;
}

struct Trial {
  Knock knock;
  double misfit = std::numeric_limits<double>::infinity();  // squared pixels, outliers cut off
};

// The camera as two: as it stood before and, numbered behind all others, afterwards.
Trial try_camera(std::size_t camera, std::size_t first_after, const RigState& state,
                 std::span<const Sighting> sightings, std::span<const Board> boards, double noise_px,
                 bool keep_intrinsics) {
  Trial trial;
  const RigState posed = posed_by_others(state, sightings, boards, camera);
  const auto views = views_of(posed, sightings, camera);
  const auto split = static_cast<std::size_t>(
      std::find_if(views.begin(), views.end(), [&](const auto* view) { return view->moment >= first_after; }) -
      views.begin());
  if (split < kFewestStretch || views.size() - split < kFewestStretch) return trial;
  const std::span<const Sighting* const> all(views);
  RigState rig = state;
  rig.cameras[camera] = resected(posed, all.first(split), boards, camera);
  rig.cameras.push_back(resected(posed, all.subspan(split), boards, camera));
  std::vector<Sighting> theirs(sightings.begin(), sightings.end());
  for (auto& sighting : theirs)
    if (sighting.camera == camera && sighting.moment >= first_after) sighting.camera = state.cameras.size();
  adjust(rig, theirs, boards, {.keep_intrinsics = keep_intrinsics, .rounds = kRounds});
  trial.misfit = misfit_of(rig, theirs, boards, noise_px);
  trial.knock.camera = camera;
  trial.knock.last_before = views[split - 1]->moment;
  trial.knock.first_after = views[split]->moment;
  trial.knock.shift_px = mean_shift(posed, rig.cameras[camera], rig.cameras.back(), all, boards);
  trial.knock.after = std::move(rig.cameras.back());
  return trial;
}

Trial& best_of(std::vector<Trial>& trials) {
  return *std::min_element(trials.begin(), trials.end(),
                           [](const auto& a, const auto& b) { return a.misfit < b.misfit; });
}

bool is_large_enough(const Knock& knock, double noise_px) {
  return knock.shift_px > std::max(kLeastKnock, kLeastShift * noise_px);
}

// With few boards the cameras' poses and lenses give way to a knock until no view looks odd. Each place it may have
// happened is then tried with everything free. Views are what is drawn at random: six numbers each.
std::optional<Knock> found_by_trying(const RigState& state, std::span<const Sighting> sightings,
                                     std::span<const Board> boards, double noise_px) {
  std::vector<std::pair<std::size_t, std::size_t>> places;  // camera, first moment after
  std::size_t all_views = 0;
  for (std::size_t camera = 0; camera < state.cameras.size(); ++camera) {
    const auto views = views_of(state, sightings, camera);
    all_views += views.size();
    if (views.size() > kFewViews) continue;
    for (std::size_t i = kFewestStretch; i + kFewestStretch <= views.size(); ++i)
      if (views[i]->moment != views[i - 1]->moment) places.emplace_back(camera, views[i]->moment);
  }
  if (places.empty()) return std::nullopt;
  RigState still = state;
  adjust(still, sightings, boards, {.rounds = kRounds});
  const double misfit = misfit_of(still, sightings, boards, noise_px);
  std::vector<Trial> trials(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    trials[i] = try_camera(places[i].first, places[i].second, state, sightings, boards, noise_px, false);
  });
  auto& best = best_of(trials);
  const double certainty = (misfit / best.misfit - 1.0) * 6.0 * static_cast<double>(all_views) / kNumbersOfACamera;
  if (certainty > kCertain && is_large_enough(best.knock, noise_px)) return std::move(best.knock);
  return std::nullopt;
}

}  // namespace

std::optional<Knock> find_knock(const RigState& state, std::span<const Sighting> sightings,
                                std::span<const Board> boards, double noise_px) {
  std::vector<Suspicion> suspicions(state.cameras.size());
  tbb::parallel_for(std::size_t{0}, suspicions.size(), [&](std::size_t camera) {
    suspicions[camera] = suspicion_of(state, sightings, boards, camera, noise_px);
  });
  const auto surest = std::max_element(suspicions.begin(), suspicions.end(),
                                       [](const auto& a, const auto& b) { return a.certainty < b.certainty; });
  if (surest == suspicions.end() || !(surest->certainty > kCertain))
    return found_by_trying(state, sightings, boards, noise_px);
  std::vector<Trial> trials(state.cameras.size());
  tbb::parallel_for(std::size_t{0}, trials.size(), [&](std::size_t camera) {
    trials[camera] = try_camera(camera, surest->first_after, state, sightings, boards, noise_px, true);
  });
  auto& best = best_of(trials);
  if (is_large_enough(best.knock, noise_px)) return std::move(best.knock);
  return std::nullopt;
}

std::string in_words(const Knock& knock, const RigState& state, std::span<const std::string> moments) {
  const auto& name = state.cameras[knock.camera].name;
  const auto when = fmt::format("between {} and {}", moments[knock.last_before], moments[knock.first_after]);
  return fmt::format("{} moved {}, by {:.1f} px", name, when, knock.shift_px);
}

}  // namespace rotunda::capture
