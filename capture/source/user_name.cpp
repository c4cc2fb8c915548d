#include "capture/source/user_name.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "capture/base/unique_fd.h"

namespace rotunda::capture {

namespace {

constexpr std::uint16_t port = 3956;
constexpr std::size_t name_bytes = 16;
constexpr std::array<std::uint8_t, 16> read_name{0x42, 0x01, 0x00, 0x84, 0, 8, 0, 1,    // READMEM, 8 bytes, request 1
                                                 0,    0,    0,    0xE8, 0, 0, 0, 16};  // 16 bytes from 0xE8
constexpr std::array<std::uint8_t, 8> good_answer{0, 0, 0x00, 0x85, 0, 4 + name_bytes, 0, 1};

}  // namespace

std::string read_user_name(const std::string& address) {
  const UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in camera{};
  camera.sin_family = AF_INET;
  camera.sin_port = htons(port);
  const timeval patience{0, 300000};
  if (!fd || inet_pton(AF_INET, address.c_str(), &camera.sin_addr) != 1 ||
      ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
      ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&camera), sizeof camera) != 0 ||
      ::send(fd.get(), read_name.data(), read_name.size(), 0) < 0)
    return "";
  std::array<char, good_answer.size() + 4 + name_bytes + 1> answer{};  // header, address, name, an end
  const ssize_t bytes = ::recv(fd.get(), answer.data(), answer.size() - 1, 0);
  const bool good = bytes == static_cast<ssize_t>(answer.size() - 1) &&
                    std::equal(good_answer.begin(), good_answer.end(), answer.begin(),
                               [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
  return good ? answer.data() + good_answer.size() + 4 : "";
}

}  // namespace rotunda::capture
