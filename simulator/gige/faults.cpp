#include "simulator/gige/faults.h"

#include <algorithm>

namespace rotunda::simulator {
namespace {

constexpr std::array<std::string_view, kFaultKinds> kNames{
    "packet_loss",     "reorder",          "duplicate",        "network_error",
    "late_frames",     "missing_trailer",  "corrupted_leader", "wrong_payload_size",
    "stall",           "silence",          "reboot",           "control_stolen",
    "slow_registers",  "over_temperature", "late_trigger",     "missed_trigger",
    "doubled_trigger", "clock_step",       "clock_drift",      "stray_packet"};
static_assert(static_cast<std::size_t>(FaultKind::stray_packet) + 1 == kFaultKinds);

// SplitMix64 (Steele, Lea, Flood 2014).
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
  return x ^ (x >> 31);
}

std::uint64_t drawn(std::uint64_t seed, FaultKind kind, const PacketSending& sending) {
  std::uint64_t hash = mixed(seed);
  for (const std::uint64_t part : {static_cast<std::uint64_t>(kind), static_cast<std::uint64_t>(sending.camera),
                                   sending.block, static_cast<std::uint64_t>(sending.packet) << 32 | sending.attempt})
    hash = mixed(hash ^ part);
  return hash;
}

}  // namespace

std::string_view to_string(FaultKind kind) {
  return kNames[static_cast<std::size_t>(kind)];
}

FaultCounts& FaultCounts::operator+=(const FaultCounts& other) {
  for (std::size_t kind = 0; kind < kFaultKinds; ++kind) fired[kind] += other.fired[kind];
  return *this;
}

bool strikes(double rate, std::uint64_t seed, FaultKind kind, const PacketSending& sending) {
  if (rate <= 0.0) return false;
  return static_cast<double>(drawn(seed, kind, sending) >> 11) * 0x1.0p-53 < rate;
}

// A burst begins at a packet with a chance that makes the share of lost packets the rate; what is sent again is sent
// packet by packet and knows no bursts.
bool is_lost(const GigeFaults& faults, const PacketSending& sending) {
  const auto& loss = faults.packet_loss;
  const auto begins = [&](double rate, std::uint32_t packet) {
    return strikes(rate, faults.seed, FaultKind::packet_loss, {sending.camera, sending.block, packet, sending.attempt});
  };
  if (loss.burst <= 1 || sending.attempt > 0) return begins(loss.rate, sending.packet);
  const double rate = loss.rate / loss.burst;
  const std::uint32_t earliest = sending.packet - std::min(sending.packet, loss.burst - 1);
  for (std::uint32_t packet = earliest; packet <= sending.packet; ++packet)
    if (begins(rate, packet)) return true;
  return false;
}

void randomise_leader(std::span<std::uint8_t> leader, std::uint64_t seed, const PacketSending& sending) {
  std::uint64_t state = drawn(seed, FaultKind::corrupted_leader, sending);
  for (auto& byte : leader) {
    state = mixed(state);
    byte = static_cast<std::uint8_t>(state);
  }
}

}  // namespace rotunda::simulator
