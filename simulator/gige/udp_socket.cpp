#include "simulator/gige/udp_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>
#include <utility>

namespace rotunda::simulator {
namespace {

sockaddr_in socket_address(Endpoint endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(endpoint.port);
  address.sin_addr.s_addr = htonl(endpoint.address);
  return address;
}

void check(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
}

void enable(int fd, int level, int option, int value) {
  check(setsockopt(fd, level, option, &value, sizeof value), "setsockopt");
}

// The kernel stamps with CLOCK_REALTIME; TAI differs from it by whole seconds.
capture::Timestamp tai_from_utc(const timespec& utc) {
  timespec utc_now{};
  clock_gettime(CLOCK_REALTIME, &utc_now);
  const auto of = [](const timespec& t) {
    return std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec};
  };
  const auto offset =
      std::chrono::round<std::chrono::seconds>(capture::RigClock::now().time_since_epoch() - of(utc_now));
  return capture::Timestamp{of(utc) + offset};
}

capture::Timestamp receive_time(msghdr& message) {
  for (cmsghdr* item = CMSG_FIRSTHDR(&message); item != nullptr; item = CMSG_NXTHDR(&message, item)) {
    if (item->cmsg_level != SOL_SOCKET || item->cmsg_type != SO_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(item), sizeof stamp);
    return tai_from_utc(stamp);
  }
  return capture::RigClock::now();
}

}  // namespace

UdpSocket::UdpSocket(Endpoint local, Sharing sharing) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  check(fd_, "socket");
  try {
    enable(fd_, SOL_SOCKET, SO_TIMESTAMPNS, 1);
    if (sharing == Sharing::with_other_sockets) enable(fd_, SOL_SOCKET, SO_REUSEADDR, 1);
    const sockaddr_in address = socket_address(local);
    check(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), "bind");
  } catch (...) {
    close(fd_);
    throw;
  }
}

UdpSocket::UdpSocket(UdpSocket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

UdpSocket::~UdpSocket() {
  if (fd_ >= 0) close(fd_);
}

std::uint16_t UdpSocket::port() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  check(getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size), "getsockname");
  return ntohs(address.sin_port);
}

std::optional<UdpSocket::Received> UdpSocket::receive(std::span<std::uint8_t> buffer) {
  sockaddr_in from{};
  iovec piece{.iov_base = buffer.data(), .iov_len = buffer.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control{};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t bytes = recvmsg(fd_, &message, MSG_DONTWAIT);
  if (bytes < 0) return std::nullopt;
  return Received{.bytes = static_cast<std::size_t>(bytes),
                  .from = {.address = ntohl(from.sin_addr.s_addr), .port = ntohs(from.sin_port)},
                  .at = receive_time(message)};
}

void UdpSocket::send(std::span<const std::uint8_t> datagram, Endpoint to) {
  const sockaddr_in address = socket_address(to);
  sendto(fd_, datagram.data(), datagram.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&address),
         sizeof address);
}

}  // namespace rotunda::simulator
