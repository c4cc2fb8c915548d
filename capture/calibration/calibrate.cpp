#include "capture/calibration/calibrate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "capture/calibration/board_refusal.h"
#include "capture/calibration/board_search.h"
#include "capture/calibration/calibration_quality.h"
#include "capture/calibration/camera_exchange.h"
#include "capture/calibration/camera_faults.h"
#include "capture/calibration/camera_graph.h"
#include "capture/calibration/camera_knock.h"
#include "capture/calibration/camera_start.h"
#include "capture/calibration/world_frame.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kOutlier = 5.0;                          // noises
constexpr double kFirstOutlier = 10.0;                    // before the noise is known well
constexpr std::ptrdiff_t kFewestAfterKnock = 8;           // boards
constexpr double kLeastGate = 0.02;                       // pixels: finer than any sensor's corners
constexpr double kLargestReach = 3.0, kLeastReach = 1.0;  // pixels about a prediction

// The way of a calibration; what each step leaves for the next.
class Calibration {
 public:
  Calibration(std::vector<std::string> moments, const CalibrateOptions& options)
      : boards_(options.boards), options_(options) {
    result_.moments = std::move(moments);
    result_.boards = boards_;
  }

  void start(std::span<const CameraModel> sizes, std::vector<Sighting> sightings,
             std::span<const std::string> why_unseen = {});
  void place();
  void adjust_all(double outliers);
  void drop_before_knocks();
  void search_again(const BoardPictures& pictures, const BoardDetector& detector, const std::stop_token& stop);
  CalibrationResult judged(const BoardPictures* pictures);
  void add_problem(std::string problem) { result_.problems.push_back(std::move(problem)); }

 private:
  AdjustmentOptions adjustment() const { return {.keep_intrinsics = all_known_, .bend = options_.bend}; }
  double outlier_px() const { return std::max(kLeastGate, kOutlier * noise_px_ * std::sqrt(2.0)); }
  void keep_cameras(const std::vector<std::size_t>& kept);
  void tell_too_few(std::size_t most_views);
  void forget_unseen_boards();
  void tell_groups(const CameraGraph& graph);
  void list_from_one_end(const CameraGraph& graph);
  bool leave_out_exchanged(const CameraGraph& graph);
  void leave_out(const Knock& knock);
  void leave_out_stretch(std::size_t camera, std::size_t first_after, bool later);

  const std::vector<Board> boards_;
  const CalibrateOptions& options_;
  bool all_known_ = false;
  std::vector<std::size_t> source_;  // of each camera: its number in the pictures
  std::vector<CameraModel> started_;
  std::vector<Sighting> sightings_;                         // with outliers
  std::set<std::pair<std::size_t, std::size_t>> left_out_;  // source, moment: before (or after) a knock
  std::vector<Sighting> good_;                              // without
  RigState state_;
  double noise_px_ = 1.0;
  CalibrationResult result_;
};

const CameraModel* known_camera(std::span<const CameraModel> known, const CameraModel& camera) {
  const auto found = std::find_if(known.begin(), known.end(), [&](const auto& k) { return k.name == camera.name; });
  if (found == known.end()) return nullptr;
  if (found->width != camera.width || found->height != camera.height)
    throw InvalidInput(fmt::format("{}: the given intrinsics are for {} x {}, the pictures are {} x {}", camera.name,
                                   found->width, found->height, camera.width, camera.height));
  return &*found;
}

std::vector<Sighting> of_camera(std::span<const Sighting> sightings, std::size_t camera) {
  std::vector<Sighting> own;
  std::copy_if(sightings.begin(), sightings.end(), std::back_inserter(own),
               [&](const auto& sighting) { return sighting.camera == camera; });
  return own;
}

std::size_t most_views(std::span<const Sighting> sightings, std::size_t cameras) {
  std::vector<std::size_t> views(cameras, 0);
  for (const auto& sighting : sightings) ++views[sighting.camera];
  return *std::max_element(views.begin(), views.end());
}

void Calibration::start(std::span<const CameraModel> sizes, std::vector<Sighting> sightings,
                        std::span<const std::string> why_unseen) {
  sightings_ = std::move(sightings);
  std::vector<std::optional<CameraStart>> starts(sizes.size());
  std::vector<std::uint8_t> known(sizes.size(), 0);
  for (std::size_t i = 0; i < sizes.size(); ++i)
    if (const auto* given = known_camera(options_.known, sizes[i])) starts[i] = CameraStart{*given, 0.0}, known[i] = 1;
  const std::size_t most = most_views(sightings_, sizes.size()), fewest = most < kFewestViews ? 1 : kFewestViews;
  tbb::parallel_for(std::size_t{0}, sizes.size(), [&](std::size_t i) {
    if (known[i] == 0) starts[i] = start_camera(sizes[i], of_camera(sightings_, i), boards_, fewest);
  });
  std::vector<std::size_t> kept;
  std::size_t from_file = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const auto views = of_camera(sightings_, i).size();
    if (starts[i] && views > 0) {
      kept.push_back(i);
      started_.push_back(starts[i]->camera);
      from_file += known[i];
      continue;
    }
    const bool told = i < why_unseen.size() && !why_unseen[i].empty();
    result_.problems.push_back(fmt::format(
        "{} saw the board {}; it takes {} at least: it is left out{}", sizes[i].name, in_times(views), fewest,
        told ? "; " + why_unseen[i] : std::string(". Show it the board at different places, tilted")));
  }
  if (kept.size() < 2)
    throw InvalidInput(fmt::format("only {} of {} cameras saw enough boards; a rig has two at least. {}", kept.size(),
                                   sizes.size(), fmt::join(result_.problems, "; ")));
  all_known_ = from_file == kept.size();
  if (!all_known_ && most < kFewestViews) tell_too_few(most);
  if (from_file > 0 && !all_known_)
    throw InvalidInput(fmt::format("the given intrinsics know {} of {} cameras only: give all of them, or none",
                                   from_file, kept.size()));
  source_.resize(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) source_[i] = i;
  keep_cameras(kept);
}

// A calibration all the same: it shows what is amiss, and may do where nothing better is to be had.
void Calibration::tell_too_few(std::size_t most_views) {
  result_.verdict = Verdict::rejected;
  result_.problems.push_back(fmt::format(
      "no camera saw the board more than {}, so lenses are mostly what lenses are like: show the board at 12 places or "
      "more, better 40, all over every picture (or give the intrinsics, where they are known)",
      in_times(most_views)));
}

// Numbers the cameras anew.
void Calibration::keep_cameras(const std::vector<std::size_t>& kept) {
  std::vector<std::size_t> source;
  std::vector<Sighting> sightings;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    source.push_back(source_[kept[i]]);
    for (auto sighting : of_camera(sightings_, kept[i])) {
      sighting.camera = i;
      sightings.push_back(std::move(sighting));
    }
  }
  source_ = std::move(source);
  sightings_ = std::move(sightings);
}

void Calibration::tell_groups(const CameraGraph& graph) {
  std::vector<std::string> groups;
  for (const auto& group : graph.groups) {
    std::vector<std::string> names;
    for (const std::size_t camera : group) names.push_back(started_[camera].name);
    groups.push_back(fmt::format("{}", fmt::join(names, ", ")));
  }
  for (std::size_t i = 1; i < graph.groups.size(); ++i) {
    result_.problems.push_back(why_apart(graph, i, started_, sightings_, boards_));
    result_.verdict = Verdict::rejected;
  }
  if (groups.size() > 1)
    result_.advice.push_back(
        fmt::format("the cameras fall into groups that never see the board together ({}): walk "
                    "the board where two groups see it at once",
                    fmt::join(groups, " | ")));
}

// Of a board that looks the same upside down: all cameras get one listing. Only several boards at different places
// tell which.
void Calibration::list_from_one_end(const CameraGraph& graph) {
  const std::set<std::pair<std::size_t, BoardKey>> turned(graph.turned.begin(), graph.turned.end());
  for (auto& sighting : sightings_)
    if (turned.contains({sighting.camera, {sighting.moment, sighting.board}}))
      for (auto& corner : sighting.corners) corner.corner = corner_count(boards_[sighting.board]) - 1 - corner.corner;
  std::map<std::size_t, int> surest;  // of each camera, with any other
  for (const auto& tie : graph.ties)
    for (const std::size_t camera : {tie.a, tie.b}) surest[camera] = std::max(surest[camera], tie.agreeing);
  std::vector<std::string> doubtful;
  for (const std::size_t camera : graph.groups.front())
    if (surest[camera] < 2) doubtful.push_back(started_[camera].name);
  if (doubtful.empty() || !std::all_of(boards_.begin(), boards_.end(), looks_the_same_upside_down)) return;
  result_.verdict = Verdict::rejected;
  result_.problems.push_back(
      fmt::format("the board looks the same upside down, and {} saw it at one place only together with another camera: "
                  "on which side of it they stand cannot be told. Show it at two places or more, or take a board of "
                  "which one side has an even and one an odd number of squares",
                  fmt::join(doubtful, ", ")));
}

// Two cameras whose plugs, or folders, changed places meanwhile: the longer stretch counts.
bool Calibration::leave_out_exchanged(const CameraGraph& graph) {
  const auto exchange = find_exchange(graph, started_, sightings_, boards_);
  if (!exchange) return false;
  const auto of_either = [&](const auto& s) { return s.camera == exchange->a || s.camera == exchange->b; };
  const auto all = std::count_if(sightings_.begin(), sightings_.end(), of_either);
  const auto after = std::count_if(sightings_.begin(), sightings_.end(),
                                   [&](const auto& s) { return of_either(s) && s.moment >= exchange->first_after; });
  const bool keep_later = 2 * after > all;
  result_.problems.push_back(fmt::format("{}; what they showed {} is left out",
                                         in_words(*exchange, started_, result_.moments),
                                         keep_later ? "before" : "afterwards"));
  result_.advice.push_back("give the two their names again, and calibrate anew");
  for (const std::size_t camera : {exchange->a, exchange->b})
    leave_out_stretch(camera, exchange->first_after, !keep_later);
  return true;
}

// What the camera saw from that moment on, or before.
void Calibration::leave_out_stretch(std::size_t camera, std::size_t first_after, bool later) {
  for (std::size_t moment = 0; moment < result_.moments.size(); ++moment)
    if ((moment >= first_after) == later) left_out_.insert({source_[camera], moment});
  std::erase_if(sightings_, [&](const auto& s) { return left_out_.contains({source_[s.camera], s.moment}); });
}

void Calibration::place() {
  auto graph = place_cameras(started_, sightings_, boards_);
  if (leave_out_exchanged(graph)) graph = place_cameras(started_, sightings_, boards_);
  tell_groups(graph);
  const auto group = graph.groups.front();
  if (group.size() < 2)
    throw InvalidInput(
        fmt::format("no two cameras saw the board at the same moment. {}", fmt::join(result_.problems, "; ")));
  list_from_one_end(graph);
  keep_cameras(group);
  std::vector<CameraModel> cameras;
  for (const std::size_t camera : group) cameras.push_back(graph.state.cameras[camera]);
  graph.state.cameras = std::move(cameras);
  state_ = std::move(graph.state);
  good_ = sightings_;
}

// Robustly with everything, then again without what is off by more than the noise allows.
void Calibration::adjust_all(double outliers) {
  auto report = adjust(state_, good_, boards_, adjustment());
  for (int i = 0; i < 2; ++i) {
    noise_px_ = report.noise_px;
    std::size_t removed = 0;
    good_ = without_outliers(state_, sightings_, boards_, std::max(kLeastGate, outliers * noise_px_ * std::sqrt(2.0)),
                             removed);
    report = adjust(state_, good_, boards_, adjustment());
  }
  noise_px_ = report.noise_px;
}

// A camera that was knocked meanwhile has one pose too many: the later one counts, if there are boards enough for it.
void Calibration::leave_out(const Knock& knock) {
  const auto later = std::count_if(sightings_.begin(), sightings_.end(), [&](const auto& sighting) {
    return sighting.camera == knock.camera && sighting.moment >= knock.first_after;
  });
  const bool keep_later = later >= kFewestAfterKnock;
  result_.problems.push_back(fmt::format("{}; its pose {} is kept", in_words(knock, state_, result_.moments),
                                         keep_later ? "afterwards" : "before, as too few boards followed,"));
  leave_out_stretch(knock.camera, knock.first_after, !keep_later);
  // What fitted the two poses as one says nothing of the one that is kept.
  std::erase_if(good_, [&](const auto& sighting) { return sighting.camera == knock.camera; });
  const auto own = of_camera(sightings_, knock.camera);
  good_.insert(good_.end(), own.begin(), own.end());
  if (keep_later) state_.cameras[knock.camera] = knock.after;
}

// One after the other, as a knocked camera disturbs its neighbours.
void Calibration::drop_before_knocks() {
  bool dropped = false;
  for (std::size_t i = 0; i < state_.cameras.size(); ++i) {
    const auto knock = find_knock(state_, sightings_, boards_, noise_px_);
    if (!knock) break;
    leave_out(*knock);
    forget_unseen_boards();
    adjust_all(kFirstOutlier);
    dropped = true;
  }
  if (dropped) result_.advice.push_back("fasten the camera that moved, and calibrate anew");
}

void Calibration::forget_unseen_boards() {
  std::set<BoardKey> seen;
  for (const auto& sighting : sightings_) seen.insert({sighting.moment, sighting.board});
  std::erase_if(state_.world_from_board, [&](const auto& entry) { return !seen.contains(entry.first); });
}

void Calibration::search_again(const BoardPictures& pictures, const BoardDetector& detector,
                               const std::stop_token& stop) {
  const double reach = std::clamp(10.0 * noise_px_, kLeastReach, kLargestReach);
  sightings_ = search_predicted(pictures, detector, state_, sightings_, source_, reach, options_, stop);
  std::erase_if(sightings_, [&](const auto& s) { return left_out_.contains({source_[s.camera], s.moment}); });
  std::size_t removed = 0;
  good_ = without_outliers(state_, sightings_, boards_, reach, removed);
}

CalibrationResult Calibration::judged(const BoardPictures* pictures) {
  for (auto& swap : find_swaps(state_, options_.known)) result_.problems.push_back(std::move(swap));
  auto world = take_world_frame(state_, good_, boards_, result_.moments, options_.world_from);
  result_.world = std::move(world.where);
  if (!world.advice.empty()) result_.advice.push_back(std::move(world.advice));
  result_.corner_noise_px = noise_px_;
  result_.kept_intrinsics = all_known_;
  tell_residuals(state_, sightings_, boards_, outlier_px(), result_);
  tell_held_out(state_, good_, boards_, adjustment(), result_);
  tell_coverage(state_, good_, boards_, result_);
  tell_deviations(state_, good_, boards_, adjustment(), result_);
  result_.cameras = state_.cameras;
  for (std::size_t i = 0; i < result_.cameras.size(); ++i) result_.cameras[i].rms_px = result_.quality[i].rms_px;
  for (const auto& [key, pose] : state_.world_from_board) result_.poses.push_back({key.first, key.second, pose});
  if (pictures != nullptr && pictures->file)
    for (auto& view : result_.views) view.picture = pictures->file(source_[view.camera], view.moment);
  judge(result_);
  return std::move(result_);
}

}  // namespace

CalibrationResult calibrate_sightings(std::span<const CameraModel> sizes, std::vector<std::string> moments,
                                      std::vector<Sighting> sightings, const CalibrateOptions& options) {
  check_boards(options.boards);
  refuse_too_little(sizes.size());
  if (sightings.empty()) throw InvalidInput("no board was found in any picture");
  Calibration calibration(std::move(moments), options);
  calibration.start(sizes, std::move(sightings));
  calibration.place();
  calibration.adjust_all(kFirstOutlier);
  calibration.drop_before_knocks();
  calibration.adjust_all(kOutlier);
  return calibration.judged(nullptr);
}

CalibrationResult calibrate(const BoardPictures& pictures, const CalibrateOptions& options,
                            const std::stop_token& stop) {
  const BoardDetector detector(options.boards);
  refuse_too_little(pictures.cameras.size());
  refuse_another_world(pictures.cameras, options.world_from);
  auto search = search_boards(pictures, detector, options, stop);
  refuse_another_board(search, pictures, options);
  if (search.sightings.empty()) throw InvalidInput("no board was found in any picture");
  Calibration calibration(pictures.moments, options);
  for (auto& trouble : search.troubles) calibration.add_problem(std::move(trouble));
  const auto unseen = why_unseen(search, pictures, options);
  calibration.start(search.sizes, std::move(search.sightings), unseen);
  calibration.place();
  calibration.adjust_all(kFirstOutlier);
  calibration.drop_before_knocks();
  for (int pass = 0; pass < (options.second_pass ? 2 : 0); ++pass) {
    calibration.search_again(pictures, detector, stop);
    calibration.adjust_all(kOutlier);
  }
  return calibration.judged(&pictures);
}

}  // namespace rotunda::capture
