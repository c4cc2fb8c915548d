#include "simulator/gige/camera_stream.h"

#include <gtest/gtest.h>
#include <netinet/in.h>

#include <algorithm>
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
  EXPECT_FALSE(stream.send_due(kStart - 1ns));
  EXPECT_TRUE(wire.received().empty());
  EXPECT_TRUE(stream.send_due(kStart));
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
  EXPECT_TRUE(stream.send_due(kStart));
  EXPECT_EQ(wire.received().size(), 7U);                      // 64 KiB at a time
  EXPECT_EQ(stream.next_burst(), kStart + 7 * (72us + 1us));  // 9000 bytes at 1 Gb/s, and the delay asked for
  EXPECT_FALSE(stream.send_due(kStart + 100us));
  EXPECT_TRUE(stream.send_due(kStart + 1ms));
  EXPECT_EQ(wire.received().size(), 7U);
}

TEST(CameraStream, ResendsWhatItKeepsAndSaysWhatIsGone) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 0.0);
  for (std::uint16_t block = 1; block <= 9; ++block) {
    stream.add(wire.frame(block), wire.destination(), 0ns, kStart);
    stream.send_due(kStart);
    wire.received();
  }
  stream.resend({.block = 2, .first = 3, .last = 5});
  auto packets = wire.received();
  ASSERT_EQ(packets.size(), 3U);
  for (const auto& packet : packets) EXPECT_EQ(status_of(packet), 0x0100);
  EXPECT_EQ(load_be<std::uint32_t>(packets[0], 4), 3U << 24 | 3U);  // a payload packet, the one asked for
  stream.resend({.block = 9, .first = 0, .last = 0xFFFFFF});
  EXPECT_EQ(wire.received().size(), 14U);
  stream.resend({.block = 1, .first = 3, .last = 5});
  packets = wire.received();
  ASSERT_EQ(packets.size(), 1U);
  EXPECT_EQ(status_of(packets[0]), 0x800C);
  EXPECT_EQ(block_of(packets[0]), 1U);
  stream.resend({.block = 9, .first = 20, .last = 10});
  EXPECT_TRUE(wire.received().empty());
  EXPECT_EQ(stream.counts().packets_resent, 17U);
  EXPECT_EQ(stream.counts().packets_unavailable, 1U);
}

TEST(CameraStream, LostPacketsNeverLeaveAndAreCounted) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 0.0);
  stream.add(wire.frame(1), wire.destination(), 0ns, kStart, {.packet_loss = {.rate = 0.5}});
  stream.send_due(kStart);
  const auto arrived = wire.received().size();
  EXPECT_LT(arrived, 14U);
  EXPECT_EQ(stream.counts().packets_lost, 14U - arrived);
  stream.add(wire.frame(2), wire.destination(), 0ns, kStart);
  stream.send_due(kStart, CameraStream::Link::silent);
  EXPECT_TRUE(wire.received().empty());
  EXPECT_EQ(stream.counts().frames_sent, 1U);
}

namespace {

// What arrives of one frame of fourteen packets sent with something wrong.
struct Faulty {
  explicit Faulty(const GigeFaults& faults) : stream(2, wire.sender.fd(), 0.0) {
    stream.add(wire.frame(1), wire.destination(), 0ns, kStart, faults);
    stream.send_due(kStart + faults.late_frames.by);
    packets = wire.received();
  }
  std::uint64_t fired(FaultKind kind) const { return stream.counts().faults[kind]; }
  std::vector<std::uint32_t> order() const {
    std::vector<std::uint32_t> ids;
    for (const auto& packet : packets) ids.push_back(load_be<std::uint32_t>(packet, 4) & 0xFFFFFF);
    return ids;
  }

  Wire wire;
  CameraStream stream;
  std::vector<Bytes> packets;
};

const std::vector<std::uint32_t> kInOrder{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};

}  // namespace

TEST(StreamFaults, NoneFiresByItself) {
  const Faulty frame({});
  EXPECT_EQ(frame.order(), kInOrder);
  EXPECT_EQ(frame.stream.counts().faults.fired, FaultCounts{}.fired);
}

TEST(StreamFaults, ReorderedPacketsAllArriveThoughLater) {
  const Faulty frame({.seed = 4, .reorder = {.rate = 0.3, .by = 2}});
  auto order = frame.order();
  EXPECT_NE(order, kInOrder);
  std::uint64_t later = 0;
  for (std::size_t i = 1; i < order.size(); ++i) later += order[i] < order[i - 1];
  EXPECT_GE(frame.fired(FaultKind::reorder), later);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, kInOrder);
}

TEST(StreamFaults, AllPacketsReorderedKeepTheirOrder) {
  EXPECT_EQ(Faulty({.reorder = {.rate = 1.0, .by = 5}}).order(), kInOrder);
}

TEST(StreamFaults, DuplicatesAreTheSamePacketAgain) {
  const Faulty frame({.duplicate = {.rate = 0.4}});
  const auto twice = frame.fired(FaultKind::duplicate);
  EXPECT_GT(twice, 0U);
  ASSERT_EQ(frame.packets.size(), 14U + twice);
  std::uint64_t equal = 0;
  for (std::size_t i = 1; i < frame.packets.size(); ++i) equal += frame.packets[i] == frame.packets[i - 1];
  EXPECT_EQ(equal, twice);
}

TEST(StreamFaults, BurstsLoseNeighboursAndTheShareAskedFor) {
  constexpr std::uint32_t kBurst = 8;
  const GigeFaults faults{.packet_loss = {.rate = 0.04, .burst = kBurst}};
  int lost = 0, runs = 0;
  bool before = false;
  for (std::uint32_t packet = 0; packet < 200'000; ++packet) {
    const bool now = is_lost(faults, {0, 1, packet, 0});
    lost += now;
    runs += now && !before;
    before = now;
  }
  EXPECT_NEAR(lost, 0.04 * 200'000, 1200);                     // some thousand bursts: five deviations
  EXPECT_NEAR(static_cast<double>(lost) / runs, kBurst, 1.0);  // some run into each other
}

TEST(StreamFaults, WhatIsSentAgainIsLostOrNotByItselfAndTheSameInEveryRun) {
  const auto arriving = [] {
    Faulty frame({.seed = 6, .packet_loss = {.rate = 0.5}});
    std::vector<std::vector<std::uint32_t>> rounds{frame.order()};
    for (int round = 0; round < 3; ++round) {
      frame.stream.resend({.block = 1, .first = 0, .last = 13});
      frame.packets = frame.wire.received();
      rounds.push_back(frame.order());
    }
    return rounds;
  };
  const auto once = arriving();
  EXPECT_EQ(once, arriving());
  EXPECT_NE(once[1], once[2]);
}

TEST(StreamFaults, NetworkErrorsAndMissingTrailersKeepPacketsBack) {
  const Faulty refused({.network_error = {.rate = 1.0}});
  EXPECT_TRUE(refused.packets.empty());
  EXPECT_EQ(refused.fired(FaultKind::network_error), 14U);
  EXPECT_EQ(refused.stream.counts().send_errors, 14U);
  const Faulty headless({.missing_trailer = {.rate = 1.0}});
  EXPECT_EQ(headless.order().size(), 13U);
  EXPECT_EQ(headless.order().back(), 12U);
  EXPECT_EQ(headless.fired(FaultKind::missing_trailer), 1U);
}

TEST(StreamFaults, AStrayPacketComesBeforeItsFrameAndIsNoneOfIt) {
  constexpr std::uint8_t kLeader = 1, kTrailer = 2, kPayload = 3;
  const Faulty frame({.stray_packet = {.rate = 1.0}});
  ASSERT_EQ(frame.packets.size(), 15U);
  for (const auto known : {kLeader, kTrailer, kPayload}) EXPECT_NE(frame.packets.front()[4], known);
  EXPECT_EQ(frame.packets[1][4], kLeader);
  EXPECT_EQ(frame.fired(FaultKind::stray_packet), 1U);
}

TEST(StreamFaults, ALateFrameWaits) {
  Wire wire;
  CameraStream stream(0, wire.sender.fd(), 0.0);
  stream.add(wire.frame(1), wire.destination(), 0ns, kStart, {.late_frames = {30ms}});
  EXPECT_EQ(stream.next_burst(), kStart + 30ms);
  EXPECT_EQ(stream.counts().faults[FaultKind::late_frames], 1U);
}

TEST(StreamFaults, ALeaderLiesInTheFieldAskedForAndNowhereElse) {
  const Faulty honest({});
  const auto differs = [&](LeaderFlaw flaw) {
    const Faulty frame({.corrupted_leader = {.flaw = flaw, .rate = 1.0}});
    EXPECT_EQ(frame.fired(FaultKind::corrupted_leader), 1U);
    EXPECT_EQ(frame.packets.size(), 14U);
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < frame.packets[0].size(); ++i)
      if (frame.packets[0][i] != honest.packets[0][i]) places.push_back(i);
    EXPECT_FALSE(places.empty());
    for (std::size_t i = 1; i < 14; ++i) EXPECT_EQ(frame.packets[i], honest.packets[i]);
    return std::pair{places.front(), places.back()};
  };
  const auto within = [&](LeaderFlaw flaw, std::size_t begin, std::size_t end) {
    const auto [first, last] = differs(flaw);
    EXPECT_GE(first, begin);
    EXPECT_LT(last, end);
  };
  within(LeaderFlaw::block_id, 2, 4);
  within(LeaderFlaw::pixel_format, 20, 24);
  within(LeaderFlaw::width, 24, 28);
  within(LeaderFlaw::height, 28, 32);
  within(LeaderFlaw::random, 8, 44);
}

TEST(StreamFaults, MoreOrFewerBytesFollowThanTheLeaderSays) {
  const Faulty shorter({.wrong_payload_size = {.sent_change = -20'000}});
  EXPECT_EQ(shorter.packets.size(), 11U);  // 80 000 of at most 8964, leader, trailer
  EXPECT_EQ(shorter.fired(FaultKind::wrong_payload_size), 1U);
  EXPECT_EQ(Faulty({.wrong_payload_size = {.sent_change = 20'000}}).packets.size(), 16U);
  EXPECT_EQ(Faulty({.wrong_payload_size = {.sent_change = -1'000'000}}).packets.size(), 2U);
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
