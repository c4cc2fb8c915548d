#include "capture/sync/frame_set_assembler.h"

#include <algorithm>
#include <set>
#include <utility>

#include "config/errors.h"

namespace rotunda::capture {

FrameSetAssembler::FrameSetAssembler(AssemblerOptions options) : options_(std::move(options)) {
  const auto& cameras = options_.cameras;
  if (cameras.empty()) throw InvalidInput("frame sets need one camera at least");
  if (std::set<CameraId>(cameras.begin(), cameras.end()).size() != cameras.size())
    throw InvalidInput("frame sets need every camera's name once; two cameras share one");
  if (options_.grid.period.count() <= 0 || options_.deadline.count() <= 0)
    throw InvalidInput("frame sets need a trigger period and a deadline longer than nothing");
  tolerance_ = options_.tolerance.value_or(options_.grid.period / 2);
  absent_.assign(cameras.size(), false);
  silent_.assign(cameras.size(), false);
  counts_.cameras.resize(cameras.size());
  ledgers_.resize(cameras.size());
}

std::size_t FrameSetAssembler::slot_of(const CameraId& camera) const {
  const auto found = std::find(options_.cameras.begin(), options_.cameras.end(), camera);
  if (found == options_.cameras.end()) throw InvalidInput("camera " + camera + " is not one of this take's");
  return static_cast<std::size_t>(found - options_.cameras.begin());
}

// Which trigger a frame belongs to: nothing before the first, after the last, between two, or in the future. The last
// keeps what a camera with a wrong clock can pile up here bounded.
std::optional<std::uint64_t> FrameSetAssembler::trigger_of(Timestamp exposure_start, Timestamp now) const {
  const std::int64_t nearest = options_.grid.nearest(exposure_start);
  if (nearest < 0 || exposure_start > now + options_.grid.period) return std::nullopt;
  const auto trigger = static_cast<std::uint64_t>(nearest);
  if (options_.triggers && trigger >= *options_.triggers) return std::nullopt;
  const auto apart = exposure_start - options_.grid.time_of(trigger);
  return std::chrono::abs(apart) <= tolerance_ ? std::optional(trigger) : std::nullopt;
}

FrameSetAssembler::Pending& FrameSetAssembler::pending(std::uint64_t trigger) {
  return pending_.try_emplace(trigger, options_.cameras.size()).first->second;
}

std::vector<FrameSet> FrameSetAssembler::add(Frame frame, Timestamp now) {
  const std::size_t camera = slot_of(frame.camera);
  auto& counts = counts_.cameras[camera];
  if (frame.id) ledgers_[camera].came(*frame.id);
  const auto trigger = trigger_of(frame.exposure_start, now);
  if (!trigger) {
    ++counts.off_grid;
  } else if (*trigger < next_) {
    ++counts.late;
  } else if (Slot& slot = pending(*trigger)[camera]; slot.frame) {
    ++counts.duplicate;
  } else {
    frame.trigger = *trigger;
    slot.frame = std::move(frame);
  }
  return collect(now);
}

std::vector<FrameSet> FrameSetAssembler::add_loss(const CameraId& camera, std::optional<Timestamp> exposure_start,
                                                  Timestamp now, HoleReason because) {
  const std::size_t slot = slot_of(camera);
  const auto trigger = exposure_start ? trigger_of(*exposure_start, now) : std::nullopt;
  if (trigger && *trigger >= next_) pending(*trigger)[slot].lost = because;
  return collect(now);
}

std::vector<FrameSet> FrameSetAssembler::set_absent(const CameraId& camera, bool absent, Timestamp now) {
  absent_[slot_of(camera)] = absent;
  return collect(now);
}

std::vector<FrameSet> FrameSetAssembler::advance(Timestamp now) {
  return collect(now);
}

std::vector<FrameSet> FrameSetAssembler::finish() {
  if (!options_.triggers) options_.triggers = pending_.empty() ? next_ : pending_.rbegin()->first + 1;
  return collect(std::nullopt);
}

std::optional<Timestamp> FrameSetAssembler::next_deadline() const {
  if (done()) return std::nullopt;
  return options_.grid.time_of(next_) + options_.deadline;
}

bool FrameSetAssembler::waits_for_nobody(const Pending& set) const {
  for (std::size_t i = 0; i < set.size(); ++i)
    if (!set[i].frame && !set[i].lost && !absent_[i]) return false;
  return true;
}

// Without a `now` every set that is left is overdue. A set nobody has sent anything for stays until its deadline even
// when all cameras are absent: it would otherwise leave before its own trigger.
std::vector<FrameSet> FrameSetAssembler::collect(std::optional<Timestamp> now) {
  std::vector<FrameSet> sets;
  for (; !done(); sets.push_back(close_next())) {
    const bool overdue = !now || *now >= *next_deadline();
    const auto begun = pending_.find(next_);
    if (!overdue && (begun == pending_.end() || !waits_for_nobody(begun->second))) break;
  }
  return sets;
}

FrameSet FrameSetAssembler::close_next() {
  FrameSet set;
  set.trigger = next_;
  set.time = options_.grid.time_of(next_);
  const auto begun = pending_.find(next_);
  Pending slots = begun == pending_.end() ? Pending(options_.cameras.size()) : std::move(begun->second);
  pending_.erase(next_++);
  for (std::size_t i = 0; i < slots.size(); ++i) set.slots.push_back(fill(i, std::move(slots[i])));
  ++(set.complete() ? counts_.complete : counts_.incomplete);
  return set;
}

FrameSlot FrameSetAssembler::fill(std::size_t camera, Slot slot) {
  auto& counts = counts_.cameras[camera];
  if (slot.frame) {
    ++counts.in_sets;
    counts.missing_in_a_row = 0;
    ledgers_[camera].left_with(*slot.frame);
    return {std::move(slot.frame), std::nullopt};
  }
  const HoleReason why = slot.lost ? *slot.lost : absent_[camera] ? HoleReason::camera_lost : why_nothing_came(camera);
  ledgers_[camera].left_without(slot.lost.has_value());
  ++counts.missing;
  ++counts.missing_in_a_row;
  ++counts.missing_because[why];
  return {std::nullopt, why};
}

// What waits for its set already tells what became of the triggers before it.
HoleReason FrameSetAssembler::why_nothing_came(std::size_t camera) const {
  std::uint64_t announced = 0;
  for (const auto& [trigger, slots] : pending_) {
    const Slot& slot = slots[camera];
    if (slot.frame && slot.frame->id)
      return ledgers_[camera].reason(ExposureLedger::Place{trigger, *slot.frame->id}, announced);
    if (slot.lost) ++announced;
  }
  return silent_[camera] ? HoleReason::camera_lost : HoleReason::late;
}

}  // namespace rotunda::capture
