#include "capture/source/stream_socket.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/filter.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include "capture/base/unique_fd.h"

namespace rotunda::capture {

namespace {

bool is_udp_on_port(int fd, std::uint16_t port) {
  int type = 0;
  socklen_t length = sizeof type;
  if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &length) != 0 || type != SOCK_DGRAM) return false;
  sockaddr_in name{};
  length = sizeof name;
  return ::getsockname(fd, reinterpret_cast<sockaddr*>(&name), &length) == 0 && name.sin_family == AF_INET &&
         ntohs(name.sin_port) == port;
}

// An open file of this process of which `is` is true.
std::optional<int> open_file(const std::function<bool(int fd)>& is) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const int fd = std::atoi(entry.path().filename().c_str());
    if (is(fd)) return fd;
  }
  return std::nullopt;
}

std::optional<int> udp_socket_on_port(std::uint16_t port) {
  return open_file([port](int fd) { return is_udp_on_port(fd, port); });
}

bool is_packet_socket(int fd) {
  int domain = 0;
  socklen_t length = sizeof domain;
  return ::getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &domain, &length) == 0 && domain == AF_PACKET;
}

// Empty: it has none. SO_GET_FILTER counts instructions, not bytes.
std::vector<sock_filter> filter_of(int fd) {
  socklen_t count = 0;
  if (::getsockopt(fd, SOL_SOCKET, SO_GET_FILTER, nullptr, &count) != 0) return {};
  std::vector<sock_filter> filter(count);
  if (count == 0 || ::getsockopt(fd, SOL_SOCKET, SO_GET_FILTER, filter.data(), &count) != 0) return {};
  return filter;
}

// Name of the interface with this address; "127.0.0.7" is the loopback's as well as "127.0.0.1".
std::string interface_with(const std::string& address) {
  in_addr wanted{};
  if (inet_pton(AF_INET, address.c_str(), &wanted) != 1) return "";
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return "";
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, ::freeifaddrs);
  for (const ifaddrs* one = list; one; one = one->ifa_next) {
    if (!one->ifa_addr || one->ifa_addr->sa_family != AF_INET) continue;
    const auto here = reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr.s_addr;
    const bool loopback = (one->ifa_flags & IFF_LOOPBACK) != 0 && ntohl(wanted.s_addr) >> 24 == 127;
    if (here == wanted.s_addr || loopback) return one->ifa_name;
  }
  return "";
}

}  // namespace

int set_receive_buffer(std::uint16_t port, int bytes) {
  const auto fd = udp_socket_on_port(port);
  if (!fd) return 0;
  if (::setsockopt(*fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0)
    ::setsockopt(*fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);  // what is granted is read back below
  int booked = 0;
  socklen_t length = sizeof booked;
  return ::getsockopt(*fd, SOL_SOCKET, SO_RCVBUF, &booked, &length) == 0 ? booked / 2 : 0;
}

bool accept_only_from(std::uint16_t port, const std::string& address) {
  const auto fd = udp_socket_on_port(port);
  in_addr sender{};
  if (!fd || inet_pton(AF_INET, address.c_str(), &sender) != 1) return false;
  constexpr std::uint32_t kSourceAddress = static_cast<std::uint32_t>(SKF_NET_OFF) + 12;  // of an IPv4 header
  std::array<sock_filter, 4> program{sock_filter{BPF_LD | BPF_W | BPF_ABS, 0, 0, kSourceAddress},
                                     sock_filter{BPF_JMP | BPF_JEQ | BPF_K, 0, 1, ntohl(sender.s_addr)},
                                     sock_filter{BPF_RET | BPF_K, 0, 0, 0xFFFFFFFF},  // all of it
                                     sock_filter{BPF_RET | BPF_K, 0, 0, 0}};          // nothing
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  return ::setsockopt(*fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0;
}

NetworkLink link_with_address(const std::string& address) {
  NetworkLink link{interface_with(address)};
  double megabits = 0.0;
  std::ifstream speed("/sys/class/net/" + link.name + "/speed");
  if (!link.name.empty() && speed >> megabits && megabits > 0.0) link.bits_per_second = megabits * 1e6;
  return link;
}

int mtu_of_interface(const std::string& address) {
  const std::string name = interface_with(address);
  const UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (name.empty() || !fd) return 0;
  ifreq request{};
  std::strncpy(request.ifr_name, name.c_str(), IFNAMSIZ - 1);
  return ::ioctl(fd.get(), SIOCGIFMTU, &request) == 0 ? request.ifr_mtu : 0;
}

bool packet_socket_listens_for(std::uint16_t port) {
  const auto asks = [port](const sock_filter& step) {
    return step.code == (BPF_JMP | BPF_JEQ | BPF_K) && step.k == port;
  };
  return open_file([&](int fd) {
           if (!is_packet_socket(fd)) return false;
           const auto filter = filter_of(fd);
           return std::any_of(filter.begin(), filter.end(), asks);
         })
      .has_value();
}

bool may_open_packet_socket() {
  return static_cast<bool>(UniqueFd(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0)));
}

}  // namespace rotunda::capture
