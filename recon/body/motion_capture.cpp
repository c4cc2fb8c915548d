#include "recon/body/motion_capture.h"

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <deque>
#include <map>
#include <memory>

#include "config/errors.h"
#include "recon/body/body_start.h"

namespace rotunda::recon {
namespace {

constexpr std::size_t kStartFrames = 24;  // looked at for somebody upright
constexpr std::size_t kGoodStarts = 3;    // then no more are looked at
constexpr std::size_t kWindow = 48;       // frames around the start that the template is solved over,
constexpr std::size_t kWindowStep = 2;    // every second of them
constexpr std::size_t kLookBack = 16;     // frames that are followed again from one that was recovered

double process_cpu_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

class MotionCapture {
 public:
  MotionCapture(OutlineSource& source, const MotionCaptureOptions& options,
                const std::function<void(std::size_t, std::size_t)>& tell, std::stop_token stop);
  MotionCaptureReport run();

 private:
  struct Start {
    std::size_t frame = 0;
    BodyStart found;
  };
  struct Work {
    std::size_t frame;
    FrameOutlines outlines;
  };

  void choose_frames();
  Start find_start();
  [[noreturn]] void refuse_start(std::size_t looked, std::size_t silhouettes, std::size_t upright) const;
  using UseOfFrame = std::function<void(const std::shared_ptr<const Work>&)>;
  void ahead(std::size_t from, std::size_t count, int direction, const UseOfFrame& use);
  void solve_template(Start& start);
  void look_back(const Start& start, const PoseFit& recovered, const std::deque<std::shared_ptr<const Work>>& passed);
  void follow(const Start& start, int direction);

  OutlineSource& source_;
  const MotionCaptureOptions& options_;
  const std::function<void(std::size_t, std::size_t)>& tell_;
  std::stop_token stop_;
  std::size_t first_ = 0, end_ = 0, done_ = 0;
  std::map<std::size_t, std::shared_ptr<const Work>> kept_;  // about the start, a megabyte a frame
  StageClock& clock_;
  MotionCaptureReport report_;
};

MotionCapture::MotionCapture(OutlineSource& source, const MotionCaptureOptions& options,
                             const std::function<void(std::size_t, std::size_t)>& tell, std::stop_token stop)
    : source_(source), options_(options), tell_(tell), stop_(std::move(stop)), clock_(source.clock()) {
  choose_frames();
}

void MotionCapture::choose_frames() {
  const auto count = source_.frame_count();
  std::tie(first_, end_) = options_.frames.value_or(std::pair<std::size_t, std::size_t>{0, count});
  end_ = std::min(end_, count);
  if (first_ >= end_)
    throw InvalidInput(fmt::format("{} has the frames 0:{}; none of them are asked for", source_.name(), count));
}

MotionCapture::Start MotionCapture::find_start() {
  const auto count = std::min(kStartFrames, end_ - first_);
  std::vector<std::size_t> frames;
  std::vector<BodyStart> starts;
  std::size_t good = 0, silhouettes = 0, upright = 0;
  for (std::size_t i = 0; i < count && good < kGoodStarts && !stop_.stop_requested(); ++i) {
    // From the middle outwards, so that both ways from the start are short.
    const std::size_t place = count / 2 + (i % 2 == 0 ? i / 2 : count - (i + 1) / 2);
    const std::size_t frame = first_ + (place % count) * (end_ - first_) / count;
    const auto seen = source_.outlines(frame);
    const auto extent = body_extent(seen);
    if (!extent) continue;
    ++silhouettes;
    if (!extent->is_upright()) continue;
    ++upright;
    auto found = clock_.run("start", [&] { return start_body(seen, options_.body); });
    if (!found) continue;
    if (fits_well(*found)) ++good;
    frames.push_back(frame);
    starts.push_back(std::move(*found));
  }
  const auto chosen = most_credible(starts);
  if (!chosen && !stop_.stop_requested()) refuse_start(count, silhouettes, upright);
  return chosen ? Start{frames[*chosen], starts[*chosen]} : Start{};
}

void MotionCapture::refuse_start(std::size_t looked, std::size_t silhouettes, std::size_t upright) const {
  if (silhouettes == 0)
    throw InvalidInput(
        fmt::format("{}: in none of {} frames do two silhouettes agree on a person; {}, and check the calibration",
                    source_.name(), looked, source_.where_to_look()));
  if (upright == 0)
    throw InvalidInput(fmt::format(
        "{}: nobody stands upright, 0.8 to 2.4 m tall, in any of {} frames; choose a range with --frames in "
        "which the person stands or walks, or check that the calibration is in metres, z up",
        source_.name(), looked));
  if (options_.body)
    throw InvalidInput(
        fmt::format("{}: who stands upright in {} of {} frames has not the measures of the person asked for ({:.2f} m "
                    "tall): is it somebody else?",
                    source_.name(), upright, looked, height_of(options_.body->measures)));
  throw InvalidInput(fmt::format(
      "{}: what stands upright in {} of {} frames is like no person of two arms and two legs; choose other frames with "
      "--frames, or {}",
      source_.name(), upright, looked, source_.where_to_look()));
}

// Silhouettes are made ahead on all threads; `use` gets them one after the other, in the order asked for.
void MotionCapture::ahead(std::size_t from, std::size_t count, int direction, const UseOfFrame& use) {
  std::size_t next = from;
  const auto source = [&](tbb::flow_control& control) -> std::size_t {
    if (count == 0 || stop_.stop_requested()) {
      control.stop();
      return 0;
    }
    --count;
    return std::exchange(next, next + static_cast<std::size_t>(direction));
  };
  const auto make = [&](std::size_t frame) {
    const auto kept = kept_.find(frame);
    return kept != kept_.end() ? kept->second : std::make_shared<const Work>(Work{frame, source_.outlines(frame)});
  };
  tbb::parallel_pipeline(
      static_cast<std::size_t>(tbb::info::default_concurrency()) + 1,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, source) &
          tbb::make_filter<std::size_t, std::shared_ptr<const Work>>(tbb::filter_mode::parallel, make) &
          tbb::make_filter<std::shared_ptr<const Work>, void>(tbb::filter_mode::serial_in_order, use));
}

// Followed for a while with what one frame told, then lengths and widths anew from all of it.
void MotionCapture::solve_template(Start& start) {
  std::size_t last = std::min(end_, start.frame + kWindow);
  const std::size_t first = last - first_ > kWindow ? last - kWindow : first_;
  last = std::min(end_, first + kWindow);
  std::vector<FrameOutlines> frames;
  std::vector<Pose> poses;
  const auto walk = [&](std::size_t from, std::size_t count, int direction) {
    BodyTracker tracker(start.found.body, start.found.fit, {});
    std::vector<std::shared_ptr<const Work>> passed;
    ahead(from, count, direction, [&](const std::shared_ptr<const Work>& work) {
      passed.push_back(work);
      const auto tracked = clock_.run("track", [&] { return tracker.track(work->outlines); });
      if (tracked.state == TrackState::lost || work->frame % kWindowStep != 0) return;
      frames.push_back(work->outlines);
      poses.push_back(tracked.fit.pose);
    });
    for (auto& work : passed) kept_[work->frame] = std::move(work);
  };
  walk(start.frame, last - start.frame, 1);
  walk(start.frame - 1, start.frame - first, -1);
  if (frames.empty() || stop_.stop_requested()) return;
  auto solved = clock_.run("template", [&] { return fit_body(start.found.body, frames, poses, 8); });
  const auto seen = source_.outlines(start.frame);
  const auto nearest = fit_pose(solved.body, seen, start.found.fit.pose, {.iterations = 12});
  start.found = {std::move(solved.body), nearest};
}

// What was recovered in a frame may have been wrong for some before it: those, `passed` with the latest last, are
// followed again from there as long as that fits better.
void MotionCapture::look_back(const Start& start, const PoseFit& recovered,
                              const std::deque<std::shared_ptr<const Work>>& passed) {
  constexpr double kBetter = 0.97;
  BodyTracker tracker(start.found.body, recovered, {});
  for (auto work = passed.rbegin(); work != passed.rend(); ++work) {
    auto& before = report_.motion.frames[(*work)->frame - first_];
    auto again = tracker.track((*work)->outlines);
    if (again.state == TrackState::lost) return;
    if (before.state != TrackState::lost && again.fit.residual > kBetter * before.fit.residual) return;
    again.state = TrackState::recovered;
    before = std::move(again);
  }
}

void MotionCapture::follow(const Start& start, int direction) {
  std::deque<std::shared_ptr<const Work>> passed;
  BodyTracker tracker(start.found.body, start.found.fit, {.only_overlap = options_.only_overlap});
  const auto track = [&](const std::shared_ptr<const Work>& work) {
    auto& tracked = report_.motion.frames[work->frame - first_];
    tracked = clock_.run("track", [&] { return tracker.track(work->outlines); });
    if (tracked.state == TrackState::recovered && !options_.only_overlap)
      clock_.run("look back", [&] { look_back(start, tracked.fit, passed); });
    passed.push_back(work);
    if (passed.size() > kLookBack) passed.pop_front();
    if (tell_) tell_(++done_, end_ - first_);
  };
  if (direction > 0)
    ahead(start.frame, end_ - start.frame, 1, track);
  else
    ahead(start.frame - 1, start.frame - first_, -1, track);
}

MotionCaptureReport MotionCapture::run() {
  const auto begun = std::chrono::steady_clock::now();
  const double cpu_begun = process_cpu_s();
  auto start = find_start();
  if (!stop_.stop_requested() && !options_.body) solve_template(start);
  report_.motion.body = start.found.body;
  report_.motion.fps = source_.fps();
  report_.motion.first_frame = first_;
  report_.motion.frames.resize(end_ - first_);
  report_.start_frame = start.frame;
  if (!stop_.stop_requested()) follow(start, 1);
  if (!stop_.stop_requested()) follow(start, -1);
  report_.interrupted = stop_.stop_requested();
  report_.stages = clock_.costs();
  report_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  report_.cpu_s = process_cpu_s() - cpu_begun;
  return report_;
}

}  // namespace

MotionCaptureReport capture_motion(OutlineSource& source, const MotionCaptureOptions& options,
                                   const std::function<void(std::size_t, std::size_t)>& progress,
                                   std::stop_token stop) {
  return MotionCapture(source, options, progress, std::move(stop)).run();
}

}  // namespace rotunda::recon
