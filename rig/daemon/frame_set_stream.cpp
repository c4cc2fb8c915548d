#include "rig/daemon/frame_set_stream.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

capture::TriggerMode ready_to_trigger(CameraFleet& fleet, double rate_hz) {
  fleet.agree_on_trigger_mode();
  fleet.share_links(rate_hz);
  const auto mode = fleet.trigger_mode();
  if (mode == capture::TriggerMode::action)
    if (const auto problems = capture::ptp_domain_problems(fleet.clocks()); !problems.empty())
      throw DeviceError("rig", fmt::format("scheduled triggers would not be in step: {}", fmt::join(problems, "; ")));
  if (fleet.streaming() > 0) return mode;
  std::string text = "no camera streams, so there is nothing to record:";
  for (const auto& worker : fleet.workers()) text += "\n  " + worker->status().problem;
  throw DeviceError("rig", text);
}

capture::AssemblerOptions assembler_options(const FrameSetStreamOptions& stream, const capture::TriggerGrid& grid,
                                            std::optional<std::uint64_t> triggers) {
  capture::AssemblerOptions options;
  options.cameras = stream.cameras;
  options.grid = grid;
  options.triggers = triggers;
  options.deadline = std::max<std::chrono::nanoseconds>(stream.deadline, 2 * grid.period);
  return options;
}

}  // namespace

FrameSetStream::FrameSetStream(FrameSetStreamOptions options, CameraFleet& fleet)
    : fleet_(fleet),
      cameras_(options.cameras),
      trigger_(
          make_take_trigger(options.trigger, ready_to_trigger(fleet, options.trigger.rate_hz), options.wanted, fleet)),
      grid_(trigger_->plan()),
      assembler_(assembler_options(options, grid_, trigger_->wanted())),
      sync_(cameras_.size()) {}

FrameSetStream::~FrameSetStream() {
  fleet_.release(this);
  trigger_.reset();  // its thread may still tell of the grid
}

void FrameSetStream::start(Sink sink) {
  sink_ = std::move(sink);
  const auto plan = trigger_->plan();  // anew: making a take's files may have taken longer than the first one's lead
  move_grid(plan);
  fleet_.set_receiver(this);
  trigger_->start([this](const capture::TriggerGrid& grid) { move_grid(grid); });
}

void FrameSetStream::stop() {
  trigger_->stop();
}

void FrameSetStream::move_grid(const capture::TriggerGrid& grid) {
  const std::lock_guard lock(mutex_);
  grid_ = grid;
  assembler_.set_grid(grid);
}

bool FrameSetStream::is_slot(const capture::CameraId& camera) const {
  return std::find(cameras_.begin(), cameras_.end(), camera) != cameras_.end();
}

void FrameSetStream::take_frame(capture::Frame&& frame) {
  if (!is_slot(frame.camera)) return;
  const std::lock_guard lock(mutex_);
  pass_on(assembler_.add(std::move(frame), capture::RigClock::now()));
}

void FrameSetStream::take_incomplete(const capture::IncompleteFrame& incomplete) {
  if (!is_slot(incomplete.camera)) return;
  const std::lock_guard lock(mutex_);
  const auto now = capture::RigClock::now();
  pass_on(assembler_.add_loss(incomplete.camera, incomplete.exposure_start, now, incomplete.because));
}

void FrameSetStream::pass_on(std::vector<capture::FrameSet> sets) {
  for (auto& set : sets) {
    sync_.add(set);
    sink_(std::move(set));
  }
}

std::optional<std::uint64_t> FrameSetStream::triggers_in_all() const {
  const auto counts = trigger_->counts();
  if (counts.finished) return counts.fired + counts.skipped;
  return trigger_->wanted();
}

// Released when it is over: a camera that runs by itself goes on sending.
bool FrameSetStream::advance() {
  const auto triggers = triggers_in_all();
  const bool more = let_go_what_is_due(triggers);
  if (!more) fleet_.release(this);
  return more;
}

bool FrameSetStream::let_go_what_is_due(std::optional<std::uint64_t> triggers) {
  const std::lock_guard lock(mutex_);
  auto now = capture::RigClock::now();
  for (const auto& worker : fleet_.workers())
    if (is_slot(worker->settings().camera))
      pass_on(assembler_.set_absent(worker->settings().camera, !worker->streaming(), now));
  if (triggers) now = std::min(now, grid_.time_of(*triggers));  // sets of triggers that were never fired stay unborn
  if (now != capture::Timestamp{}) pass_on(assembler_.advance(now));
  return !triggers || assembler_.next_trigger() < *triggers;
}

std::uint64_t FrameSetStream::late_triggers() const {
  const auto counts = trigger_->counts();
  return counts.late + counts.skipped;
}

std::uint64_t FrameSetStream::late_frames() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t late = 0;
  for (const auto& camera : assembler_.counts().cameras) late += camera.late;
  return late;
}

capture::SyncSummary FrameSetStream::sync() const {
  const std::lock_guard lock(mutex_);
  return sync_.summary();
}

capture::AssemblerCounts FrameSetStream::counts() const {
  const std::lock_guard lock(mutex_);
  return assembler_.counts();
}

}  // namespace rotunda::rig
