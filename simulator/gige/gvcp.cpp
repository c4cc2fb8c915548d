#include "simulator/gige/gvcp.h"

#include <algorithm>

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

constexpr std::uint8_t kCommandKey = 0x42;
constexpr std::uint32_t kPacketIdMask = 0x00FFFFFF;

std::vector<std::uint8_t> datagram_of(std::uint16_t first, std::uint16_t second, std::uint16_t id,
                                      std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> datagram(kGvcpHeaderBytes + payload.size());
  store_be(std::span{datagram}, 0, first);
  store_be(std::span{datagram}, 2, second);
  store_be(std::span{datagram}, 4, static_cast<std::uint16_t>(payload.size()));
  store_be(std::span{datagram}, 6, id);
  std::copy(payload.begin(), payload.end(), datagram.begin() + kGvcpHeaderBytes);
  return datagram;
}

}  // namespace

std::optional<GvcpCommand> parse_gvcp(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < kGvcpHeaderBytes || datagram[0] != kCommandKey) return std::nullopt;
  const std::size_t length = load_be<std::uint16_t>(datagram, 4);
  if (length > datagram.size() - kGvcpHeaderBytes) return std::nullopt;
  return GvcpCommand{.opcode = static_cast<GvcpOpcode>(load_be<std::uint16_t>(datagram, 2)),
                     .flags = datagram[1],
                     .id = load_be<std::uint16_t>(datagram, 6),
                     .payload = datagram.subspan(kGvcpHeaderBytes, length)};
}

std::optional<ActionCommand> parse_action(const GvcpCommand& command) {
  const bool scheduled = (command.flags & kScheduledAction) != 0;
  if (command.payload.size() < (scheduled ? 20U : 12U)) return std::nullopt;
  ActionCommand action{.device_key = load_be<std::uint32_t>(command.payload, 0),
                       .group_key = load_be<std::uint32_t>(command.payload, 4),
                       .group_mask = load_be<std::uint32_t>(command.payload, 8),
                       .at = {}};
  if (scheduled)
    action.at = capture::Timestamp{
        std::chrono::nanoseconds{static_cast<std::int64_t>(load_be<std::uint64_t>(command.payload, 12))}};
  return action;
}

std::optional<ForceIpCommand> parse_force_ip(const GvcpCommand& command) {
  if (command.payload.size() < 56) return std::nullopt;
  const std::uint64_t high = load_be<std::uint16_t>(command.payload, 2);
  return ForceIpCommand{.mac = (high << 32) | load_be<std::uint32_t>(command.payload, 4),
                        .address = load_be<std::uint32_t>(command.payload, 20)};
}

std::optional<ResendCommand> parse_resend(const GvcpCommand& command) {
  const bool extended = (command.flags & kExtendedIdRequest) != 0;
  if (command.payload.size() < (extended ? 20U : 12U)) return std::nullopt;
  const std::uint32_t mask = extended ? 0xFFFFFFFF : kPacketIdMask;
  return ResendCommand{
      .block = extended ? load_be<std::uint64_t>(command.payload, 12) : load_be<std::uint16_t>(command.payload, 2),
      .first = load_be<std::uint32_t>(command.payload, 4) & mask,
      .last = load_be<std::uint32_t>(command.payload, 8) & mask,
      .extended_ids = extended};
}

std::vector<std::uint8_t> gvcp_command(GvcpOpcode opcode, std::uint8_t flags, std::uint16_t id,
                                       std::span<const std::uint8_t> payload) {
  return datagram_of(static_cast<std::uint16_t>(kCommandKey << 8 | flags), static_cast<std::uint16_t>(opcode), id,
                     payload);
}

std::vector<std::uint8_t> gvcp_acknowledge(const GvcpCommand& command, GvcpStatus status,
                                           std::span<const std::uint8_t> payload) {
  const auto opcode = static_cast<std::uint16_t>(static_cast<std::uint16_t>(command.opcode) + 1);
  return datagram_of(static_cast<std::uint16_t>(status), opcode, command.id, payload);
}

std::vector<std::uint8_t> gvcp_pending(const GvcpCommand& command, std::chrono::milliseconds time) {
  std::vector<std::uint8_t> payload(4);
  const auto told = std::clamp<std::int64_t>(time.count(), 0, 0xFFFF);
  store_be(std::span{payload}, 2, static_cast<std::uint16_t>(told));
  return gvcp_acknowledge({.opcode = GvcpOpcode::pending, .id = command.id}, GvcpStatus::success, payload);
}

}  // namespace rotunda::simulator
