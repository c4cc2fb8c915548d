#include "simulator/gige/gvcp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rotunda::simulator {

using testing::ElementsAre;
using Bytes = std::vector<std::uint8_t>;

TEST(Gvcp, BuildsACommandByteForByte) {
  const Bytes payload{0x00, 0x00, 0x0A, 0x00};
  EXPECT_THAT(gvcp_command(GvcpOpcode::read_register, kAckWanted, 0x1234, payload),
              ElementsAre(0x42, 0x01, 0x00, 0x80, 0x00, 0x04, 0x12, 0x34, 0x00, 0x00, 0x0A, 0x00));
}

TEST(Gvcp, AcknowledgesWithTheOpcodePlusOneAndTheSameId) {
  const Bytes datagram{0x42, 0x01, 0x00, 0x82, 0x00, 0x00, 0xBE, 0xEF};
  const auto command = parse_gvcp(datagram);
  ASSERT_TRUE(command);
  EXPECT_THAT(gvcp_acknowledge(*command, GvcpStatus::access_denied, Bytes{7}),
              ElementsAre(0x80, 0x06, 0x00, 0x83, 0x00, 0x01, 0xBE, 0xEF, 7));
}

TEST(Gvcp, ReadsAScheduledAction) {
  const Bytes datagram{0x42, 0x81, 0x01, 0x00, 0x00, 0x14, 0x00, 0x05, 0,    0,    0,    1,    0,    0,
                       0,    2,    0,    0,    0,    4,    0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x02};
  const auto action = parse_action(*parse_gvcp(datagram));
  ASSERT_TRUE(action);
  EXPECT_EQ(action->device_key, 1U);
  EXPECT_EQ(action->group_key, 2U);
  EXPECT_EQ(action->group_mask, 4U);
  ASSERT_TRUE(action->at);
  EXPECT_EQ(action->at->time_since_epoch().count(), 0x100000002);
}

TEST(Gvcp, ReadsAResendRequestWith24BitPacketIds) {
  const Bytes datagram{0x42, 0x00, 0x00, 0x40, 0x00, 0x0C, 0x00, 0x05, 0,    0,
                       0x12, 0x34, 0xFF, 0x00, 0x00, 0x07, 0xFF, 0x00, 0x01, 0x00};
  const auto request = parse_resend(*parse_gvcp(datagram));
  ASSERT_TRUE(request);
  EXPECT_EQ(request->block, 0x1234);
  EXPECT_EQ(request->first, 7U);
  EXPECT_EQ(request->last, 256U);
}

TEST(Gvcp, ReadsAResendRequestWithExtendedIds) {
  const Bytes datagram{0x42, 0x10, 0x00, 0x40, 0x00, 0x14, 0x00, 0x05, 0, 0, 0, 0, 0x01, 0,
                       0,    0x07, 0xFF, 0xFF, 0xFF, 0xFF, 0,    0,    0, 1, 0, 0, 0,    2};
  const auto request = parse_resend(*parse_gvcp(datagram));
  ASSERT_TRUE(request);
  EXPECT_EQ(request->block, 0x100000002U);
  EXPECT_EQ(request->first, 0x01000007U);
  EXPECT_TRUE(request->to_the_end());
  EXPECT_TRUE(request->extended_ids);
}

TEST(Gvcp, SaysHowLongAnAcknowledgementWillTake) {
  EXPECT_THAT(gvcp_pending({.opcode = GvcpOpcode::write_register, .id = 0xBEEF}, std::chrono::milliseconds{1200}),
              ElementsAre(0, 0, 0x00, 0x89, 0x00, 0x04, 0xBE, 0xEF, 0, 0, 0x04, 0xB0));
}

TEST(Gvcp, TakesNoDatagramThatPromisesMoreThanItBrings) {
  const Bytes whole = gvcp_command(GvcpOpcode::action, kAckWanted | kScheduledAction, 1, Bytes(20));
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parse_gvcp(std::span{whole}.first(size))) << size << " bytes";
  EXPECT_TRUE(parse_gvcp(whole));
  Bytes other_key = whole;
  other_key[0] = 0x43;
  EXPECT_FALSE(parse_gvcp(other_key));
}

TEST(Gvcp, TakesNoShortPayload) {
  for (std::size_t size = 0; size < 20; ++size) {
    const Bytes datagram = gvcp_command(GvcpOpcode::action, kScheduledAction, 1, Bytes(size));
    EXPECT_FALSE(parse_action(*parse_gvcp(datagram)));
    EXPECT_EQ(parse_resend(*parse_gvcp(datagram)).has_value(), size >= 12);
    EXPECT_FALSE(parse_force_ip(*parse_gvcp(datagram)));
  }
}

}  // namespace rotunda::simulator
