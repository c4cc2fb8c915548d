#include "simulator/gige/fault_kinds.h"

#include "simulator/gige/fault_values.h"

namespace rotunda::simulator {
namespace {

using std::chrono::nanoseconds;

void read_times(FaultParameters& p, Fault& fault) {
  p.read("for", kDuration, parse_span, fault.lasts);
}

// The next so many triggers, or each whose number is a multiple.
void read_triggers(FaultParameters& p, Fault& fault, std::uint64_t& every) {
  const std::string expected = "a number of triggers from 1 on";
  std::uint64_t next = 0;
  const bool all_of_the_next = p.read("next", expected, parse_count, next);
  const bool some = p.read("every", expected, parse_count, every);
  const auto both = p.map().find("every");
  if (all_of_the_next && some) p.map().wrong(both, "every", "either next (so many triggers) or every (each n-th)");
  if (!both) p.map().require("next", expected);
  if (!all_of_the_next) return;
  every = 1;
  fault.triggers = next;
}

FaultEffect rate_only(FaultParameters& p, auto effect) {
  p.need("rate", kShare, parse_share, effect.rate);
  return effect;
}

FaultEffect delay_only(FaultParameters& p, auto effect) {
  p.need("by", kDuration, parse_span, effect.by);
  return effect;
}

FaultEffect read_loss(FaultParameters& p, Fault&) {
  PacketLoss loss;
  p.need("rate", kShare, parse_share, loss.rate);
  p.read("burst", kPackets, parse_packets, loss.burst);
  return loss;
}

FaultEffect read_reorder(FaultParameters& p, Fault&) {
  Reorder reorder;
  p.need("rate", kShare, parse_share, reorder.rate);
  p.read("by", kPackets, parse_packets, reorder.by);
  return reorder;
}

FaultEffect read_leader(FaultParameters& p, Fault&) {
  CorruptedLeader leader{.rate = 1.0};
  p.need("what", "one of width, height, pixel_format, block_id, random", parse_flaw, leader.flaw);
  p.read("rate", kShare, parse_share, leader.rate);
  return leader;
}

FaultEffect read_payload(FaultParameters& p, Fault&) {
  WrongPayloadSize wrong;
  const std::string expected = "a number of bytes, such as -1000 or 4096";
  const bool sent = p.read("sent", expected, parse_bytes, wrong.sent_change);
  const bool told = p.read("register", expected, parse_bytes, wrong.register_change);
  if (!sent && !told) p.map().require("sent", expected);
  return wrong;
}

template <class Effect>
FaultEffect timed(FaultParameters& p, Fault& fault) {
  read_times(p, fault);
  return Effect{};
}

FaultEffect read_theft(FaultParameters& p, Fault& fault) {
  ControlStolen theft;
  read_times(p, fault);
  p.map().read<bool>("exclusive", theft.exclusive, "true or false");
  return theft;
}

FaultEffect read_heat(FaultParameters& p, Fault&) {
  const auto celsius = [](const std::string& text) { return parse_number(text, "C", 0.0, 200.0); };
  OverTemperature heat;
  p.need("to", "0 to 200 degrees Celsius", celsius, heat.celsius);
  p.read("within", kDuration, parse_delay, heat.within);
  p.read("stops_at", "0 to 200 degrees Celsius", celsius, heat.stops_at);
  return heat;
}

FaultEffect read_doubled(FaultParameters& p, Fault& fault) {
  DoubledTrigger doubled;
  read_triggers(p, fault, doubled.every);
  p.read("after", kDuration, parse_span, doubled.after);
  return doubled;
}

FaultEffect read_missed(FaultParameters& p, Fault& fault) {
  MissedTrigger missed;
  read_triggers(p, fault, missed.every);
  return missed;
}

FaultEffect read_step(FaultParameters& p, Fault&) {
  ClockStep step;
  p.need("by", kDuration + ", forwards or (with a minus) back", parse_duration, step.by);
  return step;
}

FaultEffect read_drift(FaultParameters& p, Fault&) {
  ClockDrift drift;
  p.need(
      "ppm", "-10000 to 10000 parts a million", [](const auto& t) { return parse_number(t, "ppm", -1e4, 1e4); },
      drift.ppm);
  return drift;
}

}  // namespace

const std::array<FaultRow, kFaultKinds> kFaultRows{
    FaultRow{FaultKind::packet_loss, "rate", read_loss},
    {FaultKind::reorder, "rate", read_reorder},
    {FaultKind::duplicate, "rate", [](FaultParameters& p, Fault&) { return rate_only(p, Duplicate{}); }},
    {FaultKind::network_error, "rate", [](FaultParameters& p, Fault&) { return rate_only(p, NetworkError{}); }},
    {FaultKind::late_frames, "by", [](FaultParameters& p, Fault&) { return delay_only(p, LateFrames{}); }},
    {FaultKind::missing_trailer, "rate", [](FaultParameters& p, Fault&) { return rate_only(p, MissingTrailer{}); }},
    {FaultKind::corrupted_leader, "what", read_leader},
    {FaultKind::wrong_payload_size, "sent", read_payload},
    {FaultKind::stall, "for", timed<Stall>},
    {FaultKind::silence, "for", timed<Silence>},
    {FaultKind::reboot, "for", timed<Reboot>},
    {FaultKind::control_stolen, "for", read_theft},
    {FaultKind::slow_registers, "by", [](FaultParameters& p, Fault&) { return delay_only(p, SlowRegisters{}); }},
    {FaultKind::over_temperature, "to", read_heat},
    {FaultKind::late_trigger, "by", [](FaultParameters& p, Fault&) { return delay_only(p, LateTrigger{}); }},
    {FaultKind::missed_trigger, "next", read_missed},
    {FaultKind::doubled_trigger, "next", read_doubled},
    {FaultKind::clock_step, "by", read_step},
    {FaultKind::clock_drift, "ppm", read_drift},
    {FaultKind::stray_packet, "rate", [](FaultParameters& p, Fault&) { return rate_only(p, StrayPacket{}); }},
};

}  // namespace rotunda::simulator
