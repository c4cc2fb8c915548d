#include "simulator/gige/studio_sockets.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>

#include <set>
#include <system_error>

#include "config/errors.h"
#include "simulator/gige/gvcp.h"

namespace rotunda::simulator {
namespace {

constexpr std::uint32_t kLimitedBroadcast = INADDR_BROADCAST;
constexpr std::uint32_t kLoopbackBroadcast = 0x7FFFFFFF;  // 127.255.255.255

std::uint32_t ipv4(const GigeCameraOptions& camera) {
  in_addr address{};
  if (inet_pton(AF_INET, camera.address.c_str(), &address) != 1)
    throw InvalidInput(fmt::format("{}: \"{}\" is not an IPv4 address", camera.name, camera.address));
  return ntohl(address.s_addr);
}

}  // namespace

UdpSocket control_socket(const GigeCameraOptions& camera) {
  try {
    return UdpSocket({.address = ipv4(camera), .port = kGvcpPort});
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::address_in_use)
      throw DeviceError(camera.name,
                        fmt::format("{}:{} is taken; is another rotunda-sim running?", camera.address, kGvcpPort));
    if (error.code() == std::errc::address_not_available)
      throw DeviceError(camera.name,
                        fmt::format("{} is no address of this machine; simulated cameras live on 127.0.0.1, "
                                    "127.0.0.2, ... of the loopback",
                                    camera.address));
    throw;
  }
}

// Discovery and actions come by broadcast; every camera hears them through these.
std::vector<UdpSocket> broadcast_sockets() {
  std::vector<UdpSocket> sockets;
  for (const std::uint32_t address : {kLimitedBroadcast, kLoopbackBroadcast}) {
    try {
      sockets.emplace_back(Endpoint{.address = address, .port = kGvcpPort}, Sharing::with_other_sockets);
    } catch (const std::system_error& error) {
      if (address == kLimitedBroadcast)
        throw DeviceError("simulated studio",
                          fmt::format("cannot listen on 255.255.255.255:{} ({}); does another simulated camera run?",
                                      kGvcpPort, error.code().message()));
      spdlog::warn("simulated studio: broadcasts to 127.255.255.255 go unheard: {}", error.code().message());
    }
  }
  return sockets;
}

void check_distinct(const std::vector<GigeCameraOptions>& cameras) {
  std::set<std::string> seen;
  const auto add = [&](const std::string& what, const std::string& value) {
    if (!seen.insert(what + value).second)
      throw InvalidInput(fmt::format("two simulated cameras have the {} {}", what, value));
  };
  for (const auto& camera : cameras) {
    add("name", camera.name);
    add("serial", camera.serial);
    add("address", camera.address);
    add("MAC", fmt::format("{:02x}", fmt::join(camera.mac, ":")));
  }
}

UdpSocket stream_socket(const GigeCameraOptions& camera) {
  UdpSocket socket({.address = ipv4(camera), .port = 0});
  const int never_fragment = IP_PMTUDISC_DO;
  setsockopt(socket.fd(), IPPROTO_IP, IP_MTU_DISCOVER, &never_fragment, sizeof never_fragment);
  return socket;
}

UdpSocket trigger_box_socket(std::uint16_t port) {
  try {
    return UdpSocket({.address = INADDR_LOOPBACK, .port = port});
  } catch (const std::system_error& error) {
    throw DeviceError("simulated studio", fmt::format("cannot listen for the trigger box on 127.0.0.1:{} ({})", port,
                                                      error.code().message()));
  }
}

}  // namespace rotunda::simulator
