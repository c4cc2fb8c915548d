// What a camera hears: any sequence of datagrams, from two clients, at any times. The sanitizers watch; besides, the
// camera never says more than a GVCP packet holds and still answers a discovery afterwards.
// An input is a sequence of records: u8 who and how much later, u8 length, so many bytes of datagram. Under libFuzzer
// (preset `fuzz`) inputs are made up; fuzz_replay.cpp runs the same over files.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "simulator/gige/gige_device.h"
#include "simulator/gige/trigger_box.h"

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using namespace std::chrono_literals;

constexpr Timestamp kStart{1'700'000'000s};
constexpr std::size_t kMostAcknowledged = kGvcpHeaderBytes + kGvcpMaxReadBytes + 4;

void require(bool claim) {
  if (!claim) std::abort();
}

std::chrono::nanoseconds pause_of(std::uint8_t kind) {
  constexpr std::chrono::nanoseconds kPauses[]{0ns, 1us, 1ms, 40ms, 1300ms, 10s, 90s, 3h};
  return kPauses[kind >> 1 & 7];
}

// Everything the studio would fetch from the camera now.
void drain(GigeDevice& device, Timestamp now) {
  device.check_heartbeat(now);
  for (int frames = 0; frames < 40; ++frames) {
    const auto frame = device.take_due(now);
    if (!frame) break;
    require(frame->packet_size >= 576 && frame->block > 0 && frame->width > 0 && frame->height > 0);
    require(frame->offset_x + frame->width <= 720 && frame->offset_y + frame->height <= 576);
  }
  while (device.take_resend() || device.take_test_packet()) continue;
  while (const auto late = device.take_late_acknowledgement(now)) require(late->datagram.size() <= kMostAcknowledged);
}

void hear(GigeDevice& device, std::span<const std::uint8_t> datagram, Endpoint from, Timestamp now) {
  if (const auto edge = parse_line(datagram)) device.set_line0(edge->high, now);
  const auto acknowledgement = device.handle(datagram, from, now);
  require(!acknowledgement || acknowledgement->size() <= kMostAcknowledged);
  drain(device, now);
}

void run(std::span<const std::uint8_t> input) {
  static const GigeDevice powered_up(GigeCameraOptions{}, PtpStatus::slave, 50000, kStart - 1h);
  GigeDevice device = powered_up;
  Timestamp now = kStart;
  while (input.size() >= 2) {
    const std::uint8_t kind = input[0];
    const std::size_t length = std::min<std::size_t>(input[1], input.size() - 2);
    now += pause_of(kind);
    hear(device, input.subspan(2, length), {0x7F000001, static_cast<std::uint16_t>(40000 + (kind & 1))}, now);
    input = input.subspan(2 + length);
  }
  const auto found = device.handle(gvcp_command(GvcpOpcode::discovery, kAckWanted, 1, {}), {0x7F000001, 9}, now);
  require(found && found->size() == kGvcpHeaderBytes + 0xF8);
}

}  // namespace
}  // namespace rotunda::simulator

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  rotunda::simulator::run({data, size});
  return 0;
}
