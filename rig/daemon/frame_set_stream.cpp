#include "rig/daemon/frame_set_stream.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

// Of every camera before a take is given up: this machine may have been too busy to hear any of them for a moment, and
// questions asked of them then wait just as long.
constexpr std::chrono::nanoseconds kLeastSilence = 1750ms;

capture::TriggerMode ready_to_trigger(CameraFleet& fleet, const config::TriggerConfig& trigger) {
  fleet.agree_on_trigger_mode();
  fleet.share_links(trigger.rate_hz);
  const auto mode = fleet.trigger_mode();
  if (mode == capture::TriggerMode::action && trigger.lead_periods > 0)
    if (const auto problems = capture::ptp_domain_problems(fleet.clocks()); !problems.empty())
      throw DeviceError("rig", fmt::format("scheduled triggers would not be in step: {}", fmt::join(problems, "; ")));
  if (fleet.streaming() > 0) return mode;
  std::string text = "no camera streams, so there is nothing to record:";
  for (const auto& worker : fleet.workers()) text += "\n  " + worker->status().problem;
  throw DeviceError("rig", text);
}

capture::AssemblerOptions assembler_options(const std::vector<capture::CameraId>& cameras,
                                            const capture::TriggerGrid& grid, std::optional<std::uint64_t> triggers,
                                            std::chrono::nanoseconds deadline) {
  capture::AssemblerOptions options;
  options.cameras = cameras;
  options.grid = grid;
  options.triggers = triggers;
  options.deadline = deadline;
  return options;
}

}  // namespace

FrameSetStream::FrameSetStream(FrameSetStreamOptions options, CameraFleet& fleet)
    : fleet_(fleet),
      cameras_(options.cameras),
      deadline_(std::max<std::chrono::nanoseconds>(options.deadline, 2 * capture::period_of(options.trigger.rate_hz))),
      trigger_(make_take_trigger(options.trigger, ready_to_trigger(fleet, options.trigger), options.wanted, fleet)),
      grid_(trigger_->plan()),
      assembler_(assembler_options(cameras_, grid_, trigger_->wanted(), deadline_)),
      sync_(cameras_.size()),
      silence_(cameras_.size(), grid_.period) {}

FrameSetStream::~FrameSetStream() {
  fleet_.release(this);
  trigger_.reset();  // its thread may still tell of the grid
  end_silence();
}

void FrameSetStream::start(Sink sink) {
  sink_ = std::move(sink);
  const auto plan = trigger_->plan();  // anew: making a take's files may have taken longer than the first one's lead
  move_grid(plan);
  silence_.begin(plan.start);
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
  const auto now = capture::RigClock::now();
  hear(frame.camera, now);
  pass_on(assembler_.add(std::move(frame), now));
}

void FrameSetStream::take_incomplete(const capture::IncompleteFrame& incomplete) {
  if (!is_slot(incomplete.camera)) return;
  const std::lock_guard lock(mutex_);
  const auto now = capture::RigClock::now();
  hear(incomplete.camera, now);
  pass_on(assembler_.add_loss(incomplete.camera, incomplete.exposure_start, now, incomplete.because));
}

std::size_t FrameSetStream::slot_of(const capture::CameraId& camera) const {
  return static_cast<std::size_t>(std::find(cameras_.begin(), cameras_.end(), camera) - cameras_.begin());
}

void FrameSetStream::hear(const capture::CameraId& camera, capture::Timestamp now) {
  if (!silence_.heard(slot_of(camera), now)) return;
  assembler_.set_silent(camera, false);
  fleet_.worker(camera).tell_silence(false);
  incidents_.push_back(camera + " is back");
}

// Nothing is triggered any more: that nothing comes says nothing.
void FrameSetStream::end_silence() {
  for (const auto& camera : cameras_) fleet_.worker(camera).end_silence();
}

void FrameSetStream::look_for_silence(capture::Timestamp now) {
  for (const auto slot : silence_.look(now)) {
    assembler_.set_silent(cameras_[slot], true);
    fleet_.worker(cameras_[slot]).tell_silence(true);
    incidents_.push_back(cameras_[slot] + " sends no pictures any more");
  }
}

bool FrameSetStream::all_gone() const {
  const std::lock_guard lock(mutex_);
  const auto now = capture::RigClock::now();
  for (std::size_t slot = 0; slot < cameras_.size(); ++slot)
    if (silence_.silent_for(slot, now) < kLeastSilence || !fleet_.worker(cameras_[slot]).gone()) return false;
  return true;
}

void FrameSetStream::abandon() {
  const std::lock_guard lock(mutex_);
  abandoned_ = true;
}

std::vector<std::string> FrameSetStream::take_incidents() {
  const std::lock_guard lock(mutex_);
  return std::exchange(incidents_, {});
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
  if (!more) {
    fleet_.release(this);
    end_silence();
  }
  return more;
}

// Sets of triggers that were never fired stay unborn.
capture::Timestamp FrameSetStream::due_until(capture::Timestamp now, std::optional<std::uint64_t> triggers) const {
  if (!triggers) return now;
  if (*triggers == 0) return {};
  const auto last = grid_.time_of(*triggers - 1) + deadline_;
  return abandoned_ ? last : std::min(now, last);
}

bool FrameSetStream::let_go_what_is_due(std::optional<std::uint64_t> triggers) {
  const std::lock_guard lock(mutex_);
  const auto clock = capture::RigClock::now();
  if (!triggers || clock < grid_.time_of(*triggers)) look_for_silence(clock);
  const auto now = due_until(clock, triggers);
  for (const auto& worker : fleet_.workers())
    if (is_slot(worker->settings().camera))
      pass_on(assembler_.set_absent(worker->settings().camera, !worker->streaming(), now));
  pass_on(assembler_.advance(now));
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
