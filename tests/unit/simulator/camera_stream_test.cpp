#include "simulator/gige/camera_stream.h"

#include <gtest/gtest.h>
#include <netinet/in.h>

#include <array>
#include <numeric>
#include <vector>

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using Bytes = std::vector<std::uint8_t>;
using namespace std::chrono_literals;

constexpr Timestamp kStart{1000s};

// A stream to a socket of our own; datagrams on the loopback are there when send() returns.
struct Wire {
  UdpSocket sender{{INADDR_LOOPBACK, 0}}, receiver{{INADDR_LOOPBACK, 0}};
  Bytes pixels = Bytes(100'000);

  Endpoint destination() const { return {INADDR_LOOPBACK, receiver.port()}; }
  GvspFrame frame(std::uint16_t block) {
    std::iota(pixels.begin(), pixels.end(), std::uint8_t{0});
    return {
        .block = block, .exposure_start = kStart, .width = 1000, .height = 100, .packet_size = 9000, .pixels = pixels};
  }
  std::vector<Bytes> received() {
    std::vector<Bytes> all;
    std::array<std::uint8_t, 16384> buffer{};
    while (const auto datagram = receiver.receive(buffer))
      all.emplace_back(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(datagram->bytes));
    return all;
  }
};

std::uint16_t status_of(const Bytes& packet) {
  return load_be<std::uint16_t>(packet, 0);
}
std::uint16_t block_of(const Bytes& packet) {
  return load_be<std::uint16_t>(packet, 2);
}

}  // namespace

TEST(CameraStream, SendsAWholeFrameWhenItsTimeHasCome) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), /*bits_per_second=*/0.0);
  stream.add(wire.frame(1), wire.destination(), 0ns, kStart);
  EXPECT_FALSE(stream.send_due(kStart - 1ns, {}));
  EXPECT_TRUE(wire.received().empty());
  EXPECT_TRUE(stream.send_due(kStart, {}));
  const auto packets = wire.received();
  ASSERT_EQ(packets.size(), 14U);  // 12 of at most 8964 pixels, leader, trailer
  Bytes joined;
  for (std::size_t i = 1; i + 1 < packets.size(); ++i)
    joined.insert(joined.end(), packets[i].begin() + 8, packets[i].end());
  EXPECT_EQ(joined, wire.pixels);
  EXPECT_EQ(stream.counts().frames_sent, 1U);
  EXPECT_FALSE(stream.next_burst());
}

TEST(CameraStream, PacesAFrameAsItsLinkWould) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 1e9);
  stream.add(wire.frame(1), wire.destination(), /*packet_delay=*/1us, kStart);
  EXPECT_TRUE(stream.send_due(kStart, {}));
  EXPECT_EQ(wire.received().size(), 7U);                      // 64 KiB at a time
  EXPECT_EQ(stream.next_burst(), kStart + 7 * (72us + 1us));  // 9000 bytes at 1 Gb/s, and the delay asked for
  EXPECT_FALSE(stream.send_due(kStart + 100us, {}));
  EXPECT_TRUE(stream.send_due(kStart + 1ms, {}));
  EXPECT_EQ(wire.received().size(), 7U);
}

TEST(CameraStream, ResendsWhatItKeepsAndSaysWhatIsGone) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 0.0);
  for (std::uint16_t block = 1; block <= 9; ++block) {
    stream.add(wire.frame(block), wire.destination(), 0ns, kStart);
    stream.send_due(kStart, {});
    wire.received();
  }
  stream.resend({.block = 2, .first = 3, .last = 5}, {});
  auto packets = wire.received();
  ASSERT_EQ(packets.size(), 3U);
  for (const auto& packet : packets) EXPECT_EQ(status_of(packet), 0x0100);
  EXPECT_EQ(load_be<std::uint32_t>(packets[0], 4), 3U << 24 | 3U);  // a payload packet, the one asked for
  stream.resend({.block = 9, .first = 0, .last = 0xFFFFFF}, {});
  EXPECT_EQ(wire.received().size(), 14U);
  stream.resend({.block = 1, .first = 3, .last = 5}, {});
  packets = wire.received();
  ASSERT_EQ(packets.size(), 1U);
  EXPECT_EQ(status_of(packets[0]), 0x800C);
  EXPECT_EQ(block_of(packets[0]), 1U);
  stream.resend({.block = 9, .first = 20, .last = 10}, {});
  EXPECT_TRUE(wire.received().empty());
  EXPECT_EQ(stream.counts().packets_resent, 17U);
  EXPECT_EQ(stream.counts().packets_unavailable, 1U);
}

TEST(CameraStream, LostPacketsNeverLeaveAndAreCounted) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 0.0);
  stream.add(wire.frame(1), wire.destination(), 0ns, kStart);
  stream.send_due(kStart, {.packet_loss = 0.5});
  const auto arrived = wire.received().size();
  EXPECT_LT(arrived, 14U);
  EXPECT_EQ(stream.counts().packets_lost, 14U - arrived);
  stream.add(wire.frame(2), wire.destination(), 0ns, kStart);
  stream.send_due(kStart, {.silent = true});
  EXPECT_TRUE(wire.received().empty());
  EXPECT_EQ(stream.counts().frames_sent, 1U);
}

TEST(CameraStream, DropsAndCountsPacketsTheNetworkRefuses) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 0.0);
  stream.send_test_packet(wire.destination(), 70'000);  // more than UDP carries
  stream.send_test_packet(wire.destination(), 1000);
  EXPECT_EQ(wire.received().size(), 1U);
  EXPECT_EQ(stream.counts().send_errors, 1U);
}

}  // namespace rotunda::simulator
