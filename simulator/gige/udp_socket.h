#pragma once
// An IPv4 UDP socket whose datagrams carry the kernel's receive time: a camera's clock must not depend on when
// this process got to run. Throws std::system_error.
#include <cstdint>
#include <optional>
#include <span>

#include "capture/frame.h"

namespace rotunda::simulator {

struct Endpoint {
  std::uint32_t address = 0;  // IPv4, host byte order
  std::uint16_t port = 0;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

enum class Sharing { exclusive, with_other_sockets };  // SO_REUSEADDR: for broadcast addresses

class UdpSocket {
 public:
  explicit UdpSocket(Endpoint local, Sharing sharing = Sharing::exclusive);
  UdpSocket(UdpSocket&& other) noexcept;
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;
  UdpSocket& operator=(UdpSocket&&) = delete;
  ~UdpSocket();

  int fd() const { return fd_; }
  std::uint16_t port() const;  // the one the kernel chose, if it was asked for port 0

  struct Received {
    std::size_t bytes = 0;  // as kept in the buffer; longer datagrams are cut
    Endpoint from;
    capture::Timestamp at;
  };
  std::optional<Received> receive(std::span<std::uint8_t> buffer);  // nothing waits: nothing
  // Best effort, as UDP is: what the network refuses is lost.
  void send(std::span<const std::uint8_t> datagram, Endpoint to);

 private:
  int fd_ = -1;
};

}  // namespace rotunda::simulator
