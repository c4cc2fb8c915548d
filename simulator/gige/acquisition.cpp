#include "simulator/gige/acquisition.h"

#include <algorithm>

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using std::chrono::nanoseconds;

constexpr nanoseconds kFreeRunBacklog = std::chrono::seconds{1};  // held up for longer, it does not make up for frames
constexpr std::size_t kMaxPending = 16;                           // scheduled exposures

}  // namespace

void Acquisition::start(const AcquisitionSettings& settings, Timestamp at) {
  stop();
  running_ = true;
  if (settings.mode == AcquisitionMode::single_frame) frames_left_ = 1;
  if (settings.mode == AcquisitionMode::multi_frame) frames_left_ = settings.frame_count;
  if (!settings.triggered) next_free_run_ = at;
}

void Acquisition::stop() {
  *this = {};
}

void Acquisition::change_trigger_mode(bool triggered, Timestamp at) {
  next_free_run_.reset();
  if (running_ && !triggered) next_free_run_ = at;
}

GvcpStatus Acquisition::trigger(const AcquisitionSettings& settings, TriggerSource source, Timestamp at,
                                FaultSchedule& faults, DeviceCounts& counts) {
  at += settings.trigger_delay;
  const bool armed = running_ && settings.triggered && settings.source == source;
  if (!armed || was_heard(at) || overlaps_another(settings, at)) {
    ++counts.ignored_triggers;
    return GvcpStatus::success;
  }
  if (pending_.size() >= kMaxPending) return GvcpStatus::overflow;
  ++counts.triggers;
  heard_.push_back(at);
  if (heard_.size() > kMaxPending) heard_.pop_front();
  const auto number = faults.note_trigger(at);
  const auto wrong = faults.in_force(at);
  if (wrong.missed_trigger.every != 0 && number % wrong.missed_trigger.every == 0) {
    ++counts.faults[FaultKind::missed_trigger];
    return GvcpStatus::success;
  }
  counts.faults[FaultKind::late_trigger] += wrong.late_trigger.by.count() != 0;
  const Timestamp start = at + wrong.late_trigger.by;
  expose(start);
  const auto& doubled = wrong.doubled_trigger;
  if (doubled.every != 0 && number % doubled.every == 0 && !overlaps_another(settings, start + doubled.after)) {
    ++counts.faults[FaultKind::doubled_trigger];
    expose(start + doubled.after);
  }
  return GvcpStatus::success;
}

void Acquisition::expose(Timestamp start) {
  pending_.insert(std::upper_bound(pending_.begin(), pending_.end(), start), start);
}

// One action sent twice is one trigger, also if nothing came of the first.
bool Acquisition::was_heard(Timestamp at) const {
  return std::find(heard_.begin(), heard_.end(), at) != heard_.end();
}

bool Acquisition::overlaps_another(const AcquisitionSettings& settings, Timestamp start) const {
  const auto near = [&](Timestamp other) { return std::chrono::abs(start - other) < settings.exposure; };
  return (last_start_ && near(*last_start_)) || std::any_of(pending_.begin(), pending_.end(), near);
}

std::optional<Timestamp> Acquisition::next_due(const AcquisitionSettings& settings) const {
  std::optional<Timestamp> start = next_free_run_;
  if (!pending_.empty() && (!start || pending_.front() < *start)) start = pending_.front();
  if (!start) return std::nullopt;
  return *start + settings.busy_time();
}

void Acquisition::skip_missed_free_run(const AcquisitionSettings& settings, Timestamp now) {
  if (!next_free_run_ || now - *next_free_run_ < kFreeRunBacklog) return;
  *next_free_run_ += (now - *next_free_run_) / settings.period * settings.period;
}

std::optional<StartedExposure> Acquisition::take_due(const AcquisitionSettings& settings, Timestamp now,
                                                     FaultSchedule& faults) {
  skip_missed_free_run(settings, now);
  const auto due = next_due(settings);
  if (!due || *due > now) return std::nullopt;
  const StartedExposure taken{*due - settings.busy_time(), next_block(settings.extended_ids)};
  if (!pending_.empty() && pending_.front() == taken.start) {
    pending_.pop_front();
  } else {
    *next_free_run_ += settings.period;
    faults.note_trigger(taken.start);
  }
  last_start_ = taken.start;
  if (frames_left_ && --*frames_left_ == 0) stop();
  return taken;
}

std::uint64_t Acquisition::next_block(bool extended_ids) {
  last_block_ = !extended_ids && last_block_ == 65535 ? 1 : last_block_ + 1;
  return last_block_;
}

}  // namespace rotunda::simulator
