#include "simulator/gige/gvsp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct SmallFrame {
  Bytes pixels = Bytes(40 * 30);
  GvspFrame frame;
  SmallFrame() {
    std::iota(pixels.begin(), pixels.end(), std::uint8_t{0});
    frame = {.block = 0x0102,
             .exposure_start = capture::Timestamp{std::chrono::nanoseconds{0x0304050607080910}},
             .pixel_code = pixel_code(capture::PixelFormat::bayer_rg8),
             .width = 40,
             .height = 30,
             .packet_size = 576,
             .pixels = pixels};
  }
};

Bytes head_of(const GvspPacket& packet) {
  return {packet.head.begin(), packet.head.begin() + static_cast<std::ptrdiff_t>(packet.head_bytes)};
}

}  // namespace

TEST(Gvsp, LeaderIsByteForByteAnImageLeader) {
  const SmallFrame small;
  const auto leader = gvsp_packet(small.frame, 0);
  const Bytes expected{0,    0,    1,    2,    1,    0,    0,    0,  // status, block, leader, packet 0
                       0,    0,    0,    1,    0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x10,  // image, exposure start
                       0x01, 0x08, 0x00, 0x09, 0,    0,    0,    40,   0,    0,    0,    30,    // BayerRG8, 40 x 30
                       0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0,    0};    // offsets, paddings
  EXPECT_EQ(head_of(leader), expected);
  EXPECT_TRUE(leader.pixels.empty());
}

TEST(Gvsp, TrailerIsTheLastPacketAndTellsTheHeight) {
  const SmallFrame small;
  ASSERT_EQ(packet_count(small.frame), 5U);  // 540 + 540 + 120 pixels, leader, trailer
  const Bytes expected{0, 0, 1, 2, 2, 0, 0, 4, 0, 0, 0, 1, 0, 0, 0, 30};
  EXPECT_EQ(head_of(gvsp_packet(small.frame, 4)), expected);
}

TEST(Gvsp, PayloadPacketsCarryEveryPixelOnceAndInOrder) {
  const SmallFrame small;
  Bytes joined;
  for (std::uint32_t id = 1; id + 1 < packet_count(small.frame); ++id) {
    const auto packet = gvsp_packet(small.frame, id, GvspStatus::resent);
    EXPECT_EQ(head_of(packet), (Bytes{1, 0, 1, 2, 3, 0, 0, static_cast<std::uint8_t>(id)}));
    EXPECT_LE(packet.pixels.size() + kGvspOverhead, small.frame.packet_size);
    joined.insert(joined.end(), packet.pixels.begin(), packet.pixels.end());
  }
  EXPECT_EQ(joined, small.pixels);
}

TEST(Gvsp, FramesThatFillTheirPacketsExactlyHaveNoEmptyPacket) {
  SmallFrame small;
  small.frame.pixels = std::span<const std::uint8_t>{small.pixels}.first(1080);
  EXPECT_EQ(packet_count(small.frame), 4U);
  EXPECT_EQ(gvsp_packet(small.frame, 2).pixels.size(), 540U);
}

TEST(Gvsp, SaysThatAPacketIsGone) {
  EXPECT_EQ(head_of(gvsp_unavailable({.block = 9, .first = 0x010203})), (Bytes{0x80, 0x0C, 0, 9, 3, 1, 2, 3}));
}

TEST(Gvsp, ExtendedIdsTake64BitBlocksAnd32BitPackets) {
  SmallFrame small;
  small.frame.extended_ids = true;
  small.frame.block = 0x0102030405060708;
  const Bytes header{0, 0, 0, 0, 0x81, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0};
  const auto leader = gvsp_packet(small.frame, 0);
  EXPECT_EQ(leader.head_bytes, 56U);
  EXPECT_TRUE(std::equal(header.begin(), header.end(), leader.head.begin()));
  EXPECT_EQ(packet_count(small.frame), 5U);  // 528 + 528 + 144
  const auto second = gvsp_packet(small.frame, 2);
  EXPECT_EQ(second.head_bytes, 20U);
  EXPECT_EQ(second.head[4], 0x83);
  EXPECT_EQ(second.head[19], 2);
  EXPECT_EQ(second.pixels.size() + kGvspExtendedOverhead, small.frame.packet_size);
  const auto gone = gvsp_unavailable({.block = 1, .first = 5, .last = 5, .extended_ids = true});
  EXPECT_EQ(head_of(gone), (Bytes{0x80, 0x0C, 0, 0, 0x83, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 5}));
}

TEST(Gvsp, ChunksFollowThePixelsWhereverAPacketEnds) {
  for (const std::size_t pixels : {1060U, 1070U, 1080U, 1090U}) {
    SmallFrame small;
    small.frame.pixels = std::span<const std::uint8_t>{small.pixels}.first(pixels);
    small.frame.chunks = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20};
    Bytes joined, expected(small.frame.pixels.begin(), small.frame.pixels.end());
    expected.insert(expected.end(), small.frame.chunks.begin(), small.frame.chunks.end());
    for (std::uint32_t id = 1; id + 1 < packet_count(small.frame); ++id) {
      const auto packet = gvsp_packet(small.frame, id);
      EXPECT_LE(packet.pixels.size() + packet.chunks.size(), 540U);
      for (const auto part : {packet.pixels, packet.chunks}) joined.insert(joined.end(), part.begin(), part.end());
    }
    EXPECT_EQ(joined, expected) << pixels << " bytes of pixels";
    EXPECT_EQ(gvsp_packet(small.frame, 0).head[10], 0x40);  // payload type 0x4001
    const auto trailer = gvsp_packet(small.frame, packet_count(small.frame) - 1);
    EXPECT_EQ(trailer.head_bytes, 24U);  // and the payload's length and the chunks' layout
    EXPECT_EQ(load_be<std::uint32_t>(std::span<const std::uint8_t>{trailer.head}, 16), pixels + 20);
    EXPECT_EQ(trailer.head[10], 0x40);
  }
}

TEST(Gvsp, APixelsBitsAreInItsCode) {
  EXPECT_EQ(picture_bytes(pixel_code(capture::PixelFormat::rgb8), 10, 3), 90U);
  EXPECT_EQ(picture_bytes(0x010C0059, 10, 3), 45U);  // BayerRG12p
}

}  // namespace rotunda::simulator
