#include "capture/source/gvcp_memory.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>

#include "capture/base/unique_fd.h"

namespace rotunda::capture {
namespace {

constexpr std::uint16_t kPort = 3956;
constexpr std::uint8_t kReadMemory = 0x84, kReadMemoryAnswer = 0x85;
constexpr std::size_t kHeaderBytes = 8, kPlaceBytes = 4;
constexpr int kAttempts = 3;
constexpr timeval kPatience{0, 300'000};

UniqueFd socket_to(const std::string& address) {
  UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in device{};
  device.sin_family = AF_INET;
  device.sin_port = htons(kPort);
  if (!fd || inet_pton(AF_INET, address.c_str(), &device.sin_addr) != 1 ||
      ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience) != 0 ||
      ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&device), sizeof device) != 0)
    return UniqueFd();
  return fd;
}

std::uint8_t byte(std::uint32_t value, int shift) {
  return static_cast<std::uint8_t>(value >> shift);
}

// Asks for memory until an answer comes that is as wanted: that one.
template <class Wanted>
std::optional<std::string> ask(const std::string& address, std::uint32_t place, std::uint16_t bytes, Wanted wanted) {
  const UniqueFd fd = socket_to(address);
  if (!fd) return std::nullopt;
  const std::array<std::uint8_t, 16> request{0x42,
                                             0x01,
                                             0x00,
                                             kReadMemory,
                                             0,
                                             8,
                                             0,
                                             1,  // READMEM, 8 bytes follow, request 1, an answer is wanted
                                             byte(place, 24),
                                             byte(place, 16),
                                             byte(place, 8),
                                             byte(place, 0),
                                             0,
                                             0,
                                             byte(bytes, 8),
                                             byte(bytes, 0)};
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (::send(fd.get(), request.data(), request.size(), 0) < 0) continue;
    std::array<char, kHeaderBytes + kPlaceBytes + 512 + 1> answer{};
    const ssize_t got = ::recv(fd.get(), answer.data(), answer.size(), 0);
    if (got < static_cast<ssize_t>(kHeaderBytes)) continue;
    if (std::string datagram(answer.data(), static_cast<std::size_t>(got)); wanted(datagram)) return datagram;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> read_gvcp_memory(const std::string& address, std::uint32_t place, std::uint16_t bytes) {
  const std::uint32_t length = kPlaceBytes + bytes;
  const std::array<std::uint8_t, kHeaderBytes> good{0, 0, 0, kReadMemoryAnswer, byte(length, 8), byte(length, 0), 0, 1};
  const auto answer = ask(address, place, bytes, [&](const std::string& datagram) {
    return datagram.size() == kHeaderBytes + length &&
           std::equal(good.begin(), good.end(), datagram.begin(),
                      [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
  });
  return answer ? std::optional(answer->substr(kHeaderBytes + kPlaceBytes)) : std::nullopt;
}

bool answers_gvcp(const std::string& address) {
  return ask(address, 0, 4, [](const std::string& datagram) { return datagram[7] == 1; }).has_value();
}

std::string text_in(const std::string& memory) {
  return memory.substr(0, memory.find('\0'));
}

}  // namespace rotunda::capture
