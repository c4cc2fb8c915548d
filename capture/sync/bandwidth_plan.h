#pragma once
// Whether the cameras' pictures fit their links, and how their packets take turns. Cameras that are triggered together
// all start to send together: on a shared link their packets queue in the switch, and what finds no room is lost. So
// each camera leaves room for the others' packets after each of its own (GevSCPD) and starts a packet's time after the
// one before it (GevSCFTD). Pure.
#include <chrono>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "capture/frame.h"

namespace rotunda::capture {

struct LinkLoad {
  CameraId camera;
  std::string link;  // this machine's interface, "eth0"; empty: on none that is shared or known
  std::size_t frame_bytes = 0;
  int packet_size = 0;  // with IP, UDP and GVSP headers
};

// How a camera sends a frame's packets.
struct StreamPacing {
  std::chrono::nanoseconds packet_delay{};  // from one packet's end to the next one's start
  std::chrono::nanoseconds start_delay{};   // of the first packet

  friend bool operator==(const StreamPacing&, const StreamPacing&) = default;
};

struct LinkPlan {
  std::string link;
  bool fits = true;
  std::string arithmetic;  // "eth0: 10 cameras x ... = 836.6 Mbit/s of 900 usable (1000 less a tenth ...)"; and a cure
};

struct BandwidthPlan {
  std::vector<StreamPacing> pacing;  // as the loads
  std::vector<LinkPlan> links;       // that have a limit
};

// Share of a link's speed that pictures may take: the rest is for packets sent again and for talking to cameras.
inline constexpr double kUsableShareOfLink = 0.9;

// Bits of a frame on an Ethernet link: with all headers, preambles and gaps, leader and trailer.
double bits_on_the_wire(std::size_t frame_bytes, int packet_size);

// `bits_per_second` by link; a link that is not there has no limit. Throws InvalidInput for a rate or packet size that
// is not positive.
BandwidthPlan plan_bandwidth(std::span<const LinkLoad> loads, const std::map<std::string, double>& bits_per_second,
                             double rate_hz);

}  // namespace rotunda::capture
