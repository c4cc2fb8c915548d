#pragma once
// GigE Vision Control Protocol: datagrams in, datagrams out. Pure; all fields big-endian (GigE Vision 2.x, GVCP).
// Command header, 8 bytes: 0x42, flags, u16 command, u16 payload length, u16 request id.
// Acknowledge header, 8 bytes: u16 status, u16 command + 1, u16 payload length, u16 request id echoed.
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/frame.h"

namespace rotunda::simulator {

inline constexpr std::uint16_t kGvcpPort = 3956;
inline constexpr std::size_t kGvcpHeaderBytes = 8;
inline constexpr std::size_t kGvcpMaxReadBytes = 536;  // of one READMEM

enum class GvcpOpcode : std::uint16_t {
  discovery = 0x0002,
  force_ip = 0x0004,
  packet_resend = 0x0040,
  read_register = 0x0080,
  write_register = 0x0082,
  read_memory = 0x0084,
  write_memory = 0x0086,
  pending = 0x0088,  // only its acknowledgement exists: PENDING_ACK, 0x0089
  action = 0x0100,
};

enum class GvcpStatus : std::uint16_t {
  success = 0x0000,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protect = 0x8004,
  bad_alignment = 0x8005,
  access_denied = 0x8006,
  no_reference_time = 0x8013,
  overflow = 0x8015,
  action_late = 0x8016,
};

inline constexpr std::uint8_t kAckWanted = 0x01;
inline constexpr std::uint8_t kScheduledAction = 0x80;
inline constexpr std::uint8_t kExtendedIdRequest = 0x10;  // PACKETRESEND: of a stream with extended ids

// A view of one command; `payload` points into the datagram.
struct GvcpCommand {
  GvcpOpcode opcode{};  // may hold a value outside the enumeration: a command we do not know
  std::uint8_t flags = 0;
  std::uint16_t id = 0;
  std::span<const std::uint8_t> payload;

  bool wants_ack() const { return (flags & kAckWanted) != 0; }
};

struct ActionCommand {
  std::uint32_t device_key = 0, group_key = 0, group_mask = 0;
  std::optional<capture::Timestamp> at;  // nothing: at once
};

struct ForceIpCommand {
  std::uint64_t mac = 0;  // 48 bits
  std::uint32_t address = 0;
};

struct ResendCommand {
  std::uint64_t block = 0;
  std::uint32_t first = 0, last = 0;  // packet ids, both included; 24 bits unless extended
  bool extended_ids = false;

  bool to_the_end() const { return last == (extended_ids ? 0xFFFFFFFF : 0x00FFFFFF); }
};

// Nothing if this is no GVCP command: short, wrong key, or a length field that promises more than came.
std::optional<GvcpCommand> parse_gvcp(std::span<const std::uint8_t> datagram);
// Nothing if the payload is shorter than its kind asks for.
std::optional<ActionCommand> parse_action(const GvcpCommand& command);
std::optional<ForceIpCommand> parse_force_ip(const GvcpCommand& command);
std::optional<ResendCommand> parse_resend(const GvcpCommand& command);

std::vector<std::uint8_t> gvcp_command(GvcpOpcode opcode, std::uint8_t flags, std::uint16_t id,
                                       std::span<const std::uint8_t> payload);
std::vector<std::uint8_t> gvcp_acknowledge(const GvcpCommand& command, GvcpStatus status,
                                           std::span<const std::uint8_t> payload = {});
// PENDING_ACK: the acknowledgement of `command` will take about so long.
std::vector<std::uint8_t> gvcp_pending(const GvcpCommand& command, std::chrono::milliseconds time);

}  // namespace rotunda::simulator
