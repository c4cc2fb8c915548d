#include "recon/body/body_tracker.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/median.h"
#include "recon/body/limb_starts.h"

namespace rotunda::recon {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr std::size_t kMemory = 50;                     // frames a typical residual is taken over
constexpr std::size_t kPoses = 12;                      // poses remembered for starting anew
constexpr double kJump = 1.35;                          // of the typical residual: something may be wrong
constexpr double kJumpBy = 0.004;                       // metres, at least
constexpr double kLostShare = 0.55;                     // of contour points with a partner: less is no fit
constexpr std::size_t kLegTest = 8;                     // frames between tests whether the legs are held otherwise,
constexpr std::size_t kArmTest = 8;                     // or an arm;
constexpr double kNextFrame = 0.15, kAfterAGap = 0.25;  // metres a limb may be off from what is predicted
constexpr double kLimbDoubt = 1.15;                     // at once with so much of the typical residual

Pose turned(const Pose& pose, double degrees) {
  Pose result = pose;
  const Quaterniond turn(AngleAxisd(degrees * std::numbers::pi / 180.0, Vector3d::UnitZ()));
  result.rotation[0] = turn * pose.rotation[0];
  return result;
}

// How unlike two poses are: the mean turn between their joints, the pelvis left out.
double unlikeness(const Pose& a, const Pose& b) {
  double sum = 0.0;
  for (std::size_t j = 1; j < kBodyJoints; ++j) sum += a.rotation[j].angularDistance(b.rotation[j]);
  return sum / static_cast<double>(kBodyJoints - 1);
}

Pose extrapolated(const Pose& before, const Pose& last, double share) {
  Pose pose = last;
  pose.root += share * (last.root - before.root);
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const AngleAxisd step(before.rotation[j].conjugate() * last.rotation[j]);
    const double angle = std::remainder(step.angle(), 2.0 * std::numbers::pi);
    pose.rotation[j] = (last.rotation[j] * Quaterniond(AngleAxisd(share * angle, step.axis()))).normalized();
  }
  return pose;
}

}  // namespace

BodyTracker::BodyTracker(BodyTemplate body, const PoseFit& start, const TrackerOptions& options)
    : body_(std::move(body)), options_(options), last_(start.pose), residuals_{start.residual}, seen_{start.pose} {}

PoseFit BodyTracker::fit(const FrameOutlines& frame, const Pose& start, double first_scale, bool expect) const {
  PoseFitOptions options{.iterations = 6, .first_scale = first_scale, .only_overlap = options_.only_overlap};
  if (first_scale > 0.15) options.iterations = 12;
  if (expect) options.expected = start;
  return fit_pose(body_, frame, start, options);
}

Pose BodyTracker::predicted(double elapsed) const {
  constexpr double kBelief = 0.8;    // of a velocity: motions slow down sooner than they speed up,
  constexpr double kFarthest = 3.0;  // and turn back within an eighth of a second
  const double share = kBelief * std::min(elapsed, kFarthest) / last_elapsed_;
  return before_last_ && lost_ == 0 ? extrapolated(*before_last_, last_, share) : last_;
}

bool BodyTracker::is_doubtful(const PoseFit& fit) const {
  const double typical = median(residuals_);
  return fit.residual > std::max(kJump * typical, typical + kJumpBy) || fit.explained < kLostShare;
}

// The last pose, legs swapped, turned round; and what was seen before, turned the way the last one stands.
std::vector<Pose> BodyTracker::other_starts(const PoseFit& best) const {
  std::vector<Pose> starts = {last_, legs_swapped(best.pose), turned(mirrored(last_), 180.0), turned(last_, 45.0),
                              turned(last_, -45.0)};
  for (auto pose : seen_) {
    const double yaw =
                     std::atan2(last_.rotation[0].toRotationMatrix()(1, 0), last_.rotation[0].toRotationMatrix()(0, 0)),
                 own = std::atan2(pose.rotation[0].toRotationMatrix()(1, 0), pose.rotation[0].toRotationMatrix()(0, 0));
    pose = turned(pose, (yaw - own) * 180.0 / std::numbers::pi);
    pose.root = last_.root;
    starts.push_back(pose);
  }
  return starts;
}

void BodyTracker::try_starts(const FrameOutlines& frame, const std::vector<Pose>& starts, PoseFit& best) const {
  std::vector<PoseFit> coarse(starts.size());
  tbb::parallel_for(std::size_t{0}, starts.size(), [&](std::size_t i) {
    coarse[i] = fit_pose(body_, frame, starts[i],
                         {.iterations = 6, .first_scale = 0.30, .last_scale = 0.08, .spacing_px = 12.0});
  });
  std::sort(coarse.begin(), coarse.end(), [](const PoseFit& a, const PoseFit& b) { return a.residual < b.residual; });
  coarse.resize(std::min<std::size_t>(3, coarse.size()));
  for (const auto& start : coarse) {
    auto other = fit(frame, start.pose, 0.15, false);
    if (other.residual < 0.93 * best.residual) best = std::move(other);
    if (options_.hurried && !is_doubtful(best)) return;
  }
}

void BodyTracker::try_others(const FrameOutlines& frame, PoseFit& best) const {
  auto starts = other_starts(best);
  const auto extent = body_extent(frame);
  const auto move_there = [&](std::vector<Pose>& poses) {
    if (!extent || lost_ == 0) return;
    for (auto& start : poses) start.root.head<2>() += extent->centre.head<2>() - last_.root.head<2>();
  };
  auto standing = extent && extent->is_upright() ? standing_poses(body_, *extent) : std::vector<Pose>();
  if (options_.hurried) {
    move_there(starts);
    try_starts(frame, starts, best);
    if (!is_doubtful(best)) return;
    starts.clear();
  }
  starts.insert(starts.end(), standing.begin(), standing.end());
  move_there(starts);
  try_starts(frame, starts, best);
}

// One limb is a tenth of all contours: where it fits instead of being hidden in the trunk or a skirt, the whole
// residual falls by few percent. What falls less is noise, and would make limbs flip to and fro.
bool BodyTracker::try_limbs(const FrameOutlines& frame, const std::vector<Pose>& starts, PoseFit& best) const {
  constexpr double kBetter = 0.97;
  constexpr std::size_t kRefined = 2;
  constexpr double kWide = 0.16;  // metres: a trunk that leant with the wrong limb has to come back too
  std::vector<PoseFit> coarse;
  for (const auto& start : starts)
    coarse.push_back(
        fit_pose(body_, frame, start, {.iterations = 4, .first_scale = 0.15, .last_scale = 0.08, .spacing_px = 12.0}));
  std::sort(coarse.begin(), coarse.end(), [](const PoseFit& a, const PoseFit& b) { return a.residual < b.residual; });
  coarse.resize(std::min(kRefined, coarse.size()));
  bool otherwise = false;
  for (const auto& start : coarse) {
    auto other = fit(frame, start.pose, kWide, false);
    if (other.residual >= kBetter * best.residual) continue;
    best = std::move(other);
    otherwise = true;
  }
  return otherwise;
}

// Changed places is what happens most: it is not left to a coarse fit to say so.
bool BodyTracker::try_legs(const FrameOutlines& frame, PoseFit& best) const {
  const bool swapped = try_limbs(frame, {legs_swapped(best.pose)}, best);
  return try_limbs(frame, other_legs(best.pose), best) || swapped;
}

void BodyTracker::remember(const PoseFit& fit) {
  residuals_.push_back(fit.residual);
  if (residuals_.size() > kMemory) residuals_.erase(residuals_.begin());
  constexpr double kUnlike = 0.25;  // radians a joint
  if (fit.residual > 1.2 * median(residuals_)) return;
  if (std::any_of(seen_.begin(), seen_.end(), [&](const Pose& pose) { return unlikeness(pose, fit.pose) < kUnlike; }))
    return;
  if (seen_.size() == kPoses) seen_.erase(seen_.begin());
  seen_.push_back(fit.pose);
}

TrackedPose BodyTracker::track(const FrameOutlines& frame, double elapsed) {
  TrackedPose tracked;
  const auto seeing =
      std::count_if(frame.begin(), frame.end(), [](const auto& view) { return !view.outline.is_empty(); });
  const auto lose = [&](std::string why) {
    ++lost_;
    before_last_.reset();
    tracked.fit.pose = last_;
    tracked.fit.confidence.fill(0.0);
    tracked.state = TrackState::lost;
    tracked.loss = std::move(why);
    return tracked;
  };
  if (seeing < 2) return lose(fmt::format("{} of {} silhouettes show anybody", seeing, frame.size()));
  const Pose start = options_.only_overlap ? last_ : predicted(elapsed);
  tracked.fit = fit(frame, start, elapsed > 1.5 ? kAfterAGap : kNextFrame, true);
  if (!options_.only_overlap) {
    const bool doubtful = is_doubtful(tracked.fit);
    const double before = tracked.fit.residual;
    if (doubtful || lost_ > 0) try_others(frame, tracked.fit);
    ++frames_;
    const bool look = !options_.hurried && tracked.fit.residual > kLimbDoubt * median(residuals_);
    const bool arms =
        (look || frames_ % kArmTest == kArmTest / 2) && try_limbs(frame, other_arms(tracked.fit.pose), tracked.fit);
    const bool legs = (look || frames_ % kLegTest == 0) && try_legs(frame, tracked.fit);
    if (arms || legs || (doubtful && tracked.fit.residual < before)) tracked.state = TrackState::recovered;
  }
  if (tracked.fit.explained < kLostShare)
    return lose(
        fmt::format("only {:.0f} % of the silhouettes' outlines fit the template", 100.0 * tracked.fit.explained));
  if (lost_ > 0) tracked.state = TrackState::recovered;
  before_last_ = lost_ > 0 || tracked.state == TrackState::recovered ? std::nullopt : std::optional(last_);
  lost_ = 0;
  last_elapsed_ = elapsed;
  last_ = tracked.fit.pose;
  remember(tracked.fit);
  return tracked;
}

}  // namespace rotunda::recon
