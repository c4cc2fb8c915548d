#include "simulator/gige/fault_schedule.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using std::chrono::nanoseconds;

// Puts one effect among those in force; `since` is when it began.
struct TakeEffect {
  GigeFaults& into;
  nanoseconds since;

  void operator()(const PacketLoss& fault) const { into.packet_loss = fault; }
  void operator()(const Reorder& fault) const { into.reorder = fault; }
  void operator()(const Duplicate& fault) const { into.duplicate = fault; }
  void operator()(const NetworkError& fault) const { into.network_error = fault; }
  void operator()(const StrayPacket& fault) const { into.stray_packet = fault; }
  void operator()(const LateFrames& fault) const { into.late_frames = fault; }
  void operator()(const MissingTrailer& fault) const { into.missing_trailer = fault; }
  void operator()(const CorruptedLeader& fault) const { into.corrupted_leader = fault; }
  void operator()(const WrongPayloadSize& fault) const { into.wrong_payload_size = fault; }
  void operator()(const Stall&) const { into.stalled = true; }
  void operator()(const Silence&) const { into.silent = true; }
  void operator()(const Reboot&) const { into.rebooting = true; }
  void operator()(const ControlStolen& fault) const { into.control_stolen = fault; }
  void operator()(const SlowRegisters& fault) const { into.slow_registers = fault; }
  void operator()(const OverTemperature& fault) const {
    const double progress = fault.within.count() > 0 ? std::chrono::duration<double>(since) / fault.within : 1.0;
    into.heat = GigeFaults::Heat{fault, std::min(progress, 1.0)};
  }
  void operator()(const LateTrigger& fault) const { into.late_trigger = fault; }
  void operator()(const MissedTrigger& fault) const { into.missed_trigger = fault; }
  void operator()(const DoubledTrigger& fault) const { into.doubled_trigger = fault; }
  void operator()(const ClockStep& fault) const {
    into.clock_error += fault.by;
    into.clock_steps = true;
  }
  void operator()(const ClockDrift&) const { into.clock_drifts = true; }  // what it gained: gained_by()
};

nanoseconds gained_by(const ClockDrift& drift, nanoseconds during) {
  return nanoseconds{std::llround(drift.ppm * 1e-6 * static_cast<double>(during.count()))};
}

}  // namespace

void FaultSchedule::Entry::begin_at(Timestamp at) {
  begin = at;
  if (fault.lasts) end = at + *fault.lasts;
}

// A drift that ended still counts for what the clock has gained.
bool FaultSchedule::Entry::is_over(Timestamp at) const {
  return told_end && end && *end <= at && !std::holds_alternative<ClockDrift>(fault.effect);
}

void FaultSchedule::set_standing(const GigeFaults& faults) {
  standing_ = faults;
  seed_ = faults.seed;
}

bool FaultSchedule::add(const Fault& fault, Timestamp from) {
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.is_over(from); }),
                 entries_.end());
  if (entries_.size() >= kMaxFaults) return false;
  auto& entry = entries_.emplace_back(Entry{.fault = fault, .begin = {}, .end = {}, .first_trigger = {}});
  if (!fault.at_trigger) entry.begin_at(from + fault.after);
  return true;
}

void FaultSchedule::clear() {
  standing_ = {};
  entries_.clear();
}

std::uint64_t FaultSchedule::note_trigger(Timestamp at) {
  ++triggers_;
  for (auto& entry : entries_) {
    const auto& fault = entry.fault;
    if (!entry.begin && fault.at_trigger && triggers_ >= *fault.at_trigger) entry.begin_at(at + fault.after);
    if (!fault.triggers || !entry.begin || at < *entry.begin || entry.end) continue;
    if (!entry.first_trigger) entry.first_trigger = triggers_;
    if (triggers_ >= *entry.first_trigger + *fault.triggers) entry.end = at;
  }
  return triggers_;
}

GigeFaults FaultSchedule::in_force(Timestamp at) const {
  GigeFaults faults = standing_;
  faults.seed = seed_;
  for (const auto& entry : entries_) {
    if (!entry.begin || at < *entry.begin) continue;
    if (const auto* drift = std::get_if<ClockDrift>(&entry.fault.effect))
      faults.clock_error += gained_by(*drift, (entry.end ? std::min(*entry.end, at) : at) - *entry.begin);
    if (entry.holds(at)) std::visit(TakeEffect{faults, at - *entry.begin}, entry.fault.effect);
  }
  return faults;
}

std::vector<FaultKind> FaultSchedule::kinds_in_force(Timestamp at) const {
  std::vector<FaultKind> kinds;
  for (const auto& entry : entries_)
    if (entry.holds(at)) kinds.push_back(kind_of(entry.fault.effect));
  std::sort(kinds.begin(), kinds.end());
  kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
  return kinds;
}

std::vector<FaultEdge> FaultSchedule::take_edges(Timestamp now) {
  std::vector<FaultEdge> due;
  for (auto& entry : entries_) {
    const auto tell = [&](const std::optional<Timestamp>& when, bool& told, bool begins) {
      if (!when || *when > now || std::exchange(told, true)) return;
      due.push_back({kind_of(entry.fault.effect), begins, *when});
    };
    tell(entry.begin, entry.told_begin, true);
    tell(entry.end, entry.told_end, false);
  }
  std::stable_sort(due.begin(), due.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  return due;
}

}  // namespace rotunda::simulator
