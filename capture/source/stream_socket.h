#pragma once
// The UDP socket a GigE Vision stream receives on. Aravis sets its buffer only once the first packet is in, so that the
// first frame is lost; we find the socket by its port and set the buffer before the camera starts.
#include <cstdint>
#include <string>

namespace rotunda::capture {

inline constexpr int wanted_socket_buffer_bytes = 4 << 20;

// Sets SO_RCVBUF (SO_RCVBUFFORCE where allowed) of this process's UDP socket bound to `port`; returns the bytes granted
// as asked for (half of what the kernel books), or 0 if no such socket was found.
int set_receive_buffer(std::uint16_t port, int bytes);

// From now on the kernel drops what comes to that socket from elsewhere than `address`: anybody on the network could
// put pixels into a frame. False if there is no such socket, or no filter to be had.
bool accept_only_from(std::uint16_t port, const std::string& address);

// The network interface of this machine that has an address.
struct NetworkLink {
  std::string name;              // "eth0"; empty: none has it
  double bits_per_second = 0.0;  // as it says in /sys/class/net; 0: has no limit or does not tell (loopback)
};
NetworkLink link_with_address(const std::string& address);

// MTU of the interface with this IPv4 address, or 0 if there is none.
int mtu_of_interface(const std::string& address);

// Whether this process may open packet sockets (CAP_NET_RAW).
bool may_open_packet_socket();
// Whether a packet socket of this process has a filter by now that asks for this UDP port.
bool packet_socket_listens_for(std::uint16_t port);

}  // namespace rotunda::capture
