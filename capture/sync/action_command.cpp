#include "capture/sync/action_command.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "config/errors.h"

namespace rotunda::capture {

namespace {

constexpr std::uint8_t command_key = 0x42;
constexpr std::uint8_t flag_ack_wanted = 0x01;
constexpr std::uint8_t flag_scheduled = 0x80;
constexpr std::uint16_t action_cmd = 0x0100;
constexpr std::uint16_t action_ack = 0x0101;
constexpr std::size_t header_bytes = 8;

template <class Unsigned>
void put(std::vector<std::uint8_t>& bytes, Unsigned value) {
  for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::uint16_t get_u16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

sockaddr_in ipv4(const std::string& address, std::uint16_t port) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(port);
  if (inet_pton(AF_INET, address.c_str(), &result.sin_addr) != 1)
    throw InvalidInput("action commands: \"" + address + "\" is no IPv4 address; expected one such as 192.168.1.1");
  return result;
}

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), "action commands: " + what);
}

UniqueFd broadcast_socket(const std::string& interface_address) {
  UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) fail("socket");
  const int on = 1;
  if (::setsockopt(fd.get(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on) != 0) fail("SO_BROADCAST");
  // The limited broadcast leaves by the interface that has the source address.
  const sockaddr_in source = ipv4(interface_address, 0);
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&source), sizeof source) != 0)
    fail("no network interface has the address " + interface_address + "; set trigger.interface to one that has");
  return fd;
}

void count(ActionAckCounts& counts, ActionStatus status) {
  switch (status) {
    case ActionStatus::success:
      ++counts.accepted;
      return;
    case ActionStatus::late:
      ++counts.late;
      return;
    case ActionStatus::overflow:
      ++counts.overflow;
      return;
    case ActionStatus::no_reference_time:
      ++counts.no_reference_time;
      return;
    default:
      ++counts.other_errors;
  }
}

}  // namespace

std::vector<std::uint8_t> build_action_command(const ActionCommand& command, std::uint16_t request_id) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(28);
  put(bytes, command_key);
  put(bytes, static_cast<std::uint8_t>(flag_ack_wanted | (command.at ? flag_scheduled : 0)));
  put(bytes, action_cmd);
  put(bytes, static_cast<std::uint16_t>(command.at ? 20 : 12));
  put(bytes, request_id);
  put(bytes, command.device_key);
  put(bytes, command.group_key);
  put(bytes, command.group_mask);
  if (command.at) put(bytes, static_cast<std::uint64_t>(command.at->time_since_epoch().count()));
  return bytes;
}

std::optional<ActionAck> parse_action_ack(std::span<const std::uint8_t> datagram) {
  if (datagram.size() < header_bytes || get_u16(datagram, 2) != action_ack) return std::nullopt;
  if (datagram.size() < header_bytes + get_u16(datagram, 4)) return std::nullopt;
  return ActionAck{static_cast<ActionStatus>(get_u16(datagram, 0)), get_u16(datagram, 6)};
}

ActionCommandSender::ActionCommandSender(const ActionSenderOptions& options)
    : socket_(broadcast_socket(options.interface_address)), destination_(options.destination) {
  ipv4(destination_, gvcp_port);  // told now, not at the first trigger
}

std::uint16_t ActionCommandSender::send(const ActionCommand& command) {
  const std::lock_guard lock(mutex_);
  drain();
  request_id_ = static_cast<std::uint16_t>(request_id_ == 0xFFFF ? 1 : request_id_ + 1);  // 0 is no request id
  const auto datagram = build_action_command(command, request_id_);
  const sockaddr_in to = ipv4(destination_, gvcp_port);
  if (::sendto(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) <
      0)
    fail("cannot send to " + destination_);
  ++sent_;
  acks_to_last_ = 0;
  return request_id_;
}

void ActionCommandSender::drain() {
  std::array<std::uint8_t, 64> datagram{};
  sockaddr_in from{};
  for (;;) {
    socklen_t length = sizeof from;
    const ssize_t bytes =
        ::recvfrom(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (bytes < 0) return;  // nothing more; a refused datagram shows as cameras that did not answer
    const auto ack = parse_action_ack({datagram.data(), static_cast<std::size_t>(bytes)});
    if (!ack) continue;
    std::array<char, INET_ADDRSTRLEN> address{};
    inet_ntop(AF_INET, &from.sin_addr, address.data(), address.size());
    count(acks_[address.data()], ack->status);
    if (ack->request_id == request_id_) ++acks_to_last_;
  }
}

void ActionCommandSender::collect_acks(std::chrono::milliseconds timeout, std::size_t expected) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      drain();
      if (acks_to_last_ >= expected) return;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return;
    pollfd readable{socket_.get(), POLLIN, 0};
    ::poll(&readable, 1, static_cast<int>(left.count()));
  }
}

std::uint64_t ActionCommandSender::sent() const {
  const std::lock_guard lock(mutex_);
  return sent_;
}

std::map<std::string, ActionAckCounts> ActionCommandSender::acks() const {
  const std::lock_guard lock(mutex_);
  return acks_;
}

}  // namespace rotunda::capture
