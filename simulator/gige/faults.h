#pragma once
// What may go wrong with a simulated camera, and what of it is wrong at one moment. Plain values; FaultSchedule says
// when. docs/simulator-faults.md describes every fault as its user sees it.
// Random faults are functions of seed, kind, camera, block, packet and attempt: a run can be repeated.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

namespace rotunda::simulator {

// A rate is the share of those that could be struck, 0 to 1.

// --- packets of the stream, resent ones included
struct PacketLoss {  // never leave
  double rate = 0.0;
  std::uint32_t burst = 1;  // so many in a row; the rate is that of packets, not of bursts
};
struct Reorder {  // leave after those that follow them
  double rate = 0.0;
  std::uint32_t by = 3;  // packets later
};
struct Duplicate {  // leave twice
  double rate = 0.0;
};
struct NetworkError {  // refused by the network, as by a full transmit queue
  double rate = 0.0;
};
struct StrayPacket {  // before a frame comes a packet that is none of a stream; the rate is of the frames
  double rate = 0.0;
};

// --- frames
struct LateFrames {  // leave later than they should
  std::chrono::nanoseconds by{};
};
struct MissingTrailer {
  double rate = 0.0;
};
enum class LeaderFlaw { width, height, pixel_format, block_id, random };
struct CorruptedLeader {
  LeaderFlaw flaw = LeaderFlaw::random;
  double rate = 0.0;  // of the leaders
};
struct WrongPayloadSize {
  std::int64_t register_change = 0;  // bytes PayloadSize tells too many, or too few
  std::int64_t sent_change = 0;      // bytes that follow a leader beyond what it says, or short of it
};
struct Stall {};  // exposed but never sent; the control channel answers

// --- the link and the control channel
struct Silence {};  // hears nothing, sends nothing
struct Reboot {};   // registers as at power-up, nobody in control; silent while it lasts
struct ControlStolen {
  bool exclusive = true;  // the other controller lets nobody read either
};
struct SlowRegisters {  // answers to register and memory commands leave later
  std::chrono::nanoseconds by{};
};

// --- the camera itself
struct OverTemperature {
  double celsius = 90.0;              // where the temperature rises to
  std::chrono::nanoseconds within{};  // and how long that takes
  std::optional<double> stops_at;     // no frames from this temperature on
};
struct LateTrigger {  // the exposure starts later
  std::chrono::nanoseconds by{};
};
struct MissedTrigger {      // no exposure
  std::uint64_t every = 0;  // those whose number is a multiple of it; 0: none
};
struct DoubledTrigger {  // a second exposure follows
  std::uint64_t every = 0;
  std::chrono::nanoseconds after{std::chrono::milliseconds{10}};  // from one start to the other
};
struct ClockStep {  // the camera's clock is ahead by this while it lasts
  std::chrono::nanoseconds by{};
};
struct ClockDrift {  // the camera's clock gains while it lasts, and keeps what it gained
  double ppm = 0.0;
};

using FaultEffect =
    std::variant<PacketLoss, Reorder, Duplicate, NetworkError, LateFrames, MissingTrailer, CorruptedLeader,
                 WrongPayloadSize, Stall, Silence, Reboot, ControlStolen, SlowRegisters, OverTemperature, LateTrigger,
                 MissedTrigger, DoubledTrigger, ClockStep, ClockDrift, StrayPacket>;

// In the order of FaultEffect's alternatives.
enum class FaultKind : std::size_t {
  packet_loss,
  reorder,
  duplicate,
  network_error,
  late_frames,
  missing_trailer,
  corrupted_leader,
  wrong_payload_size,
  stall,
  silence,
  reboot,
  control_stolen,
  slow_registers,
  over_temperature,
  late_trigger,
  missed_trigger,
  doubled_trigger,
  clock_step,
  clock_drift,
  stray_packet,
};
inline constexpr std::size_t kFaultKinds = std::variant_size_v<FaultEffect>;

std::string_view to_string(FaultKind kind);  // as it is written in files and answers
inline FaultKind kind_of(const FaultEffect& effect) {
  return static_cast<FaultKind>(effect.index());
}

// How often each kind fired, in the unit its struct above speaks of (docs/simulator-faults.md has the list).
struct FaultCounts {
  std::array<std::uint64_t, kFaultKinds> fired{};

  std::uint64_t& operator[](FaultKind kind) { return fired[static_cast<std::size_t>(kind)]; }
  std::uint64_t operator[](FaultKind kind) const { return fired[static_cast<std::size_t>(kind)]; }
  FaultCounts& operator+=(const FaultCounts& other);
};

// Everything that is wrong with one camera at one moment. By default nothing is.
struct GigeFaults {
  std::uint64_t seed = 1;
  PacketLoss packet_loss;
  Reorder reorder;
  Duplicate duplicate;
  NetworkError network_error;
  StrayPacket stray_packet;
  LateFrames late_frames;
  MissingTrailer missing_trailer;
  CorruptedLeader corrupted_leader;
  WrongPayloadSize wrong_payload_size;
  bool stalled = false;
  bool silent = false;
  bool rebooting = false;
  std::optional<ControlStolen> control_stolen;
  SlowRegisters slow_registers;
  struct Heat {
    OverTemperature fault;
    double progress = 1.0;  // share of the rise that is over
  };
  std::optional<Heat> heat;
  LateTrigger late_trigger;
  MissedTrigger missed_trigger;
  DoubledTrigger doubled_trigger;
  std::chrono::nanoseconds clock_error{};  // the camera's clock minus the one it should show
  bool clock_steps = false, clock_drifts = false;

  bool is_away() const { return silent || rebooting; }
};

// One sending of one packet.
struct PacketSending {
  std::size_t camera = 0;
  std::uint64_t block = 0;
  std::uint32_t packet = 0;
  std::uint32_t attempt = 0;  // 0 at first, then counts the times it was sent again
};

// Whether a random fault of that kind and rate strikes this sending.
bool strikes(double rate, std::uint64_t seed, FaultKind kind, const PacketSending& sending);
bool is_lost(const GigeFaults& faults, const PacketSending& sending);  // packet_loss, with its bursts

// The bytes of a leader after its packet header, made wrong in a way that depends on the sending alone.
void randomise_leader(std::span<std::uint8_t> leader, std::uint64_t seed, const PacketSending& sending);

}  // namespace rotunda::simulator
