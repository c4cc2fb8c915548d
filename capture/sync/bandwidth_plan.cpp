#include "capture/sync/bandwidth_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

// IEEE 802.3: preamble and start 8, addresses and type 14, check sequence 4, gap 12.
constexpr double kEthernetBytes = 38;
constexpr int kStreamHeaderBytes = 36;        // IP 20, UDP 8, GVSP 8
constexpr double kLeaderAndTrailer = 36 + 8;  // bytes of an image's leader and trailer after their headers
constexpr double kSmallestPacket = 46;        // that an Ethernet frame is filled up to
constexpr double kMegabit = 1e6;

double packets_of(std::size_t frame_bytes, int packet_size) {
  return std::ceil(static_cast<double>(frame_bytes) / (packet_size - kStreamHeaderBytes));
}

std::chrono::nanoseconds nanoseconds_of(double seconds) {
  return std::chrono::nanoseconds(std::llround(std::max(0.0, seconds) * 1e9));
}

std::string arithmetic_of(const std::string& link, const std::vector<const LinkLoad*>& cameras, double needed,
                          double speed, double rate_hz) {
  double frame_bytes = 0.0;
  std::vector<CameraId> names;
  for (const auto* load : cameras) names.push_back(load->camera);
  for (const auto* load : cameras) frame_bytes += bits_on_the_wire(load->frame_bytes, load->packet_size) / 8;
  const double usable = kUsableShareOfLink * speed;
  auto text = fmt::format(
      "{}: {} camera{} x {:.0f} bytes a frame with headers x {:g} Hz = {:.1f} Mbit/s of the {:.1f} usable ({:g} Mbit/s "
      "less a tenth for packets sent again)",
      link, cameras.size(), cameras.size() == 1 ? "" : "s", frame_bytes / static_cast<double>(cameras.size()), rate_hz,
      needed / kMegabit, usable / kMegabit, speed / kMegabit);
  if (needed > usable)
    text +=
        fmt::format("; lower trigger.rate_hz to {:.1f}, make width and height smaller, or spread {} over more links",
                    std::floor(rate_hz * usable / needed * 10) / 10, fmt::join(names, ", "));
  return text;
}

// The others' packets fit between two of ours; a camera with many more packets than the others takes shorter pauses, to
// be done when the next frame is due.
StreamPacing pacing_of(const LinkLoad& load, std::size_t place, std::size_t cameras, double packet_time,
                       double rate_hz) {
  const double packets = packets_of(load.frame_bytes, load.packet_size);
  const double room = kUsableShareOfLink / rate_hz / packets - packet_time;
  const double others = static_cast<double>(cameras - 1) * packet_time;
  return {nanoseconds_of(std::min(others, room)), nanoseconds_of(static_cast<double>(place) * packet_time)};
}

}  // namespace

double bits_on_the_wire(std::size_t frame_bytes, int packet_size) {
  const double packets = packets_of(frame_bytes, packet_size);
  const double ends = 2 * (kStreamHeaderBytes + kEthernetBytes) + std::max(kLeaderAndTrailer, kSmallestPacket);
  return 8 * (static_cast<double>(frame_bytes) + packets * (kStreamHeaderBytes + kEthernetBytes) + ends);
}

BandwidthPlan plan_bandwidth(std::span<const LinkLoad> loads, const std::map<std::string, double>& bits_per_second,
                             double rate_hz) {
  if (!(rate_hz > 0.0)) throw InvalidInput("a bandwidth plan needs a rate of more than 0 Hz");
  BandwidthPlan plan;
  plan.pacing.resize(loads.size());
  for (const auto& [link, speed] : bits_per_second) {
    if (!(speed > 0.0)) continue;
    std::vector<const LinkLoad*> cameras;
    double needed = 0.0, packet_time = 0.0;
    for (const auto& load : loads) {
      if (load.link != link) continue;
      if (load.packet_size <= kStreamHeaderBytes)
        throw InvalidInput(fmt::format("{}: packets of {} bytes hold no picture", load.camera, load.packet_size));
      cameras.push_back(&load);
      needed += rate_hz * bits_on_the_wire(load.frame_bytes, load.packet_size);
      packet_time = std::max(packet_time, 8 * (load.packet_size + kEthernetBytes) / speed);
    }
    if (cameras.empty()) continue;
    plan.links.push_back(
        {link, needed <= kUsableShareOfLink * speed, arithmetic_of(link, cameras, needed, speed, rate_hz)});
    if (cameras.size() == 1) continue;
    for (std::size_t i = 0; i < cameras.size(); ++i)
      plan.pacing[static_cast<std::size_t>(cameras[i] - loads.data())] =
          pacing_of(*cameras[i], i, cameras.size(), packet_time, rate_hz);
  }
  return plan;
}

}  // namespace rotunda::capture
