#include "recon/live_motion.h"

#include <tbb/parallel_for.h>

#include <opencv2/core.hpp>

#include "recon/live/live_silhouette.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kMeasuredOver = 24;  // frames
constexpr int kGiveUp = 25;                // frames in a row without the person: a second at the usual rate
constexpr double kFrameTime = 0.040;       // seconds: what the tracker takes for the next frame
constexpr std::size_t kTries = 6;          // of which the most credible start is taken, if one is at all
constexpr double kSpacing = 4.0;           // of outline points, half-size pixels

std::string why_nobody(const FrameOutlines& frame) {
  const auto extent = body_extent(frame);
  if (!extent) return "nobody is seen by two cameras";
  if (!extent->is_upright()) return "nobody stands upright";
  return "what stands there is like no person of two arms and two legs";
}

}  // namespace

std::string_view to_string(LiveMotionState state) {
  switch (state) {
    case LiveMotionState::searching:
      return "searching";
    case LiveMotionState::tracked:
      return "tracked";
    case LiveMotionState::recovered:
      return "recovered";
    case LiveMotionState::lost:
      break;
  }
  return "lost";
}

LiveMotionFrame LiveMotion::follow(const FrameOutlines& frame, double seconds) {
  if (!tracker_) return search(frame);
  auto tracked = tracker_->track(frame, seconds / kFrameTime);
  if (tracked.state == TrackState::lost) {
    if (++lost_ > kGiveUp) tracker_.reset();
    return {LiveMotionState::lost, tracked.loss, body_, tracked.fit};
  }
  lost_ = 0;
  if (!measured_) measure(frame, tracked.fit.pose);
  const auto state = tracked.state == TrackState::recovered ? LiveMotionState::recovered : LiveMotionState::tracked;
  return {state, "", body_, tracked.fit};
}

// One that fits well is taken at once, else the most credible of some frames: what coarse pictures show never fits
// well.
std::optional<BodyStart> LiveMotion::start_of(const FrameOutlines& frame) {
  auto start = start_body(frame, std::nullopt);
  if (!start || fits_well(*start)) return start && fits_well(*start) ? start : std::nullopt;
  starts_.push_back(std::move(*start));
  if (starts_.size() < kTries) return std::nullopt;
  const auto chosen = most_credible(starts_);
  const auto body = chosen ? std::optional(starts_[*chosen].body) : std::nullopt;
  starts_.clear();
  return body ? start_body(frame, body) : std::nullopt;
}

// First who was there before, then anybody: people come and go.
LiveMotionFrame LiveMotion::search(const FrameOutlines& frame) {
  auto start = measured_ ? start_body(frame, body_) : std::nullopt;
  if (!start || !fits_well(*start)) {
    start = start_of(frame);
    if (!start) return {LiveMotionState::searching, why_nobody(frame), std::nullopt, {}};
    measured_ = false;
    frames_.clear();
    poses_.clear();
  }
  starts_.clear();
  body_ = start->body;
  tracker_ = std::make_unique<BodyTracker>(*body_, start->fit, TrackerOptions{.hurried = true});
  lost_ = 0;
  return {LiveMotionState::recovered, "", body_, start->fit};
}

// Lengths and widths anew, from all of some frames together.
void LiveMotion::measure(const FrameOutlines& frame, const Pose& pose) {
  frames_.push_back(frame);
  poses_.push_back(pose);
  if (frames_.size() < kMeasuredOver) return;
  auto solved = fit_body(*body_, frames_, poses_, 8);
  body_ = std::move(solved.body);
  tracker_ = std::make_unique<BodyTracker>(*body_, fit_pose(*body_, frame, pose, {.iterations = 12}),
                                           TrackerOptions{.hurried = true});
  measured_ = true;
  frames_.clear();
  poses_.clear();
}

FrameOutlines live_outlines(std::span<const LiveView> views, std::span<const capture::CameraModel> cameras) {
  FrameOutlines frame(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    const auto& matte = views[i].matte;
    capture::Matte whole{cv::Mat::zeros(matte.picture.planes[0].size(), CV_8UC1)};
    if (!matte.alpha.empty()) matte.alpha.copyTo(whole.alpha(matte.box));
    frame[i] = {reduced_camera(cameras[views[i].slot], 2), silhouette_outline(whole, {.spacing_px = kSpacing})};
  });
  return frame;
}

}  // namespace rotunda::recon
