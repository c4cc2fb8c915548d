#include "capture/sync/action_command.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>

#include "config/errors.h"
#include "tests/support/private_network.h"

namespace rotunda::capture {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(ActionCommand, IsTwentyBytesWhenImmediate) {
  const ActionCommand command{.device_key = 0x01020304, .group_key = 0x0A0B0C0D, .group_mask = 0xFFFFFFFF, .at = {}};
  EXPECT_EQ(build_action_command(command, 0x1234),
            (Bytes{0x42, 0x01, 0x01, 0x00, 0x00, 0x0C, 0x12, 0x34,  // command, ack wanted, ACTION_CMD, 12 bytes, id
                   1,    2,    3,    4,    0x0A, 0x0B, 0x0C, 0x0D, 0xFF, 0xFF, 0xFF, 0xFF}));
}

TEST(ActionCommand, CarriesItsTimeInNanosecondsWhenScheduled) {
  const ActionCommand command{
      .device_key = 1, .group_key = 2, .group_mask = 4, .at = Timestamp(std::chrono::nanoseconds(0x1122334455667788))};
  EXPECT_EQ(build_action_command(command, 7),
            (Bytes{0x42, 0x81, 0x01, 0x00, 0x00, 0x14, 0x00, 0x07,  // flag 0x80: scheduled; 20 bytes
                   0,    0,    0,    1,    0,    0,    0,    2,    0,    0,
                   0,    4,    0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88}));
}

TEST(ActionAck, TellsStatusAndRequest) {
  const Bytes late{0x80, 0x16, 0x01, 0x01, 0x00, 0x00, 0x12, 0x34};
  const auto ack = parse_action_ack(late);
  ASSERT_TRUE(ack);
  EXPECT_EQ(ack->status, ActionStatus::late);
  EXPECT_EQ(ack->request_id, 0x1234);
}

TEST(ActionAck, IsNotReadFromAnythingElse) {
  const Bytes good{0x00, 0x00, 0x01, 0x01, 0x00, 0x00, 0x12, 0x34};
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(parse_action_ack(std::span(good).first(length))) << length << " bytes";
  EXPECT_FALSE(parse_action_ack(Bytes{0x00, 0x00, 0x00, 0x81, 0x00, 0x00, 0x12, 0x34})) << "READREG_ACK";
  EXPECT_FALSE(parse_action_ack(Bytes{0x00, 0x00, 0x01, 0x01, 0x00, 0x04, 0x12, 0x34})) << "shorter than it says";
}

// A camera's GVCP port, as far as actions go: listens where `listen_at` and answers from `address`.
class ActionListener {
 public:
  explicit ActionListener(const char* listen_at, const char* address)
      : socket_(bound(listen_at)), from_(bound(address)) {}

  Bytes answer(std::uint16_t status) {
    std::array<std::uint8_t, 64> datagram{};
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t bytes =
        ::recvfrom(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (bytes < 8) return {};
    const std::array<std::uint8_t, 8> ack{static_cast<std::uint8_t>(status >> 8),
                                          static_cast<std::uint8_t>(status),
                                          1,
                                          1,
                                          0,
                                          0,
                                          datagram[6],
                                          datagram[7]};
    ::sendto(from_.get(), ack.data(), ack.size(), 0, reinterpret_cast<const sockaddr*>(&from), length);
    return {datagram.begin(), datagram.begin() + bytes};
  }

 private:
  static UniqueFd bound(const char* address) {
    UniqueFd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const int on = 1;
    ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    const timeval patience{5, 0};
    ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(gvcp_port);
    inet_pton(AF_INET, address, &name.sin_addr);
    EXPECT_EQ(::bind(fd.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name), 0) << address;
    return fd;
  }

  UniqueFd socket_;
  UniqueFd from_;
};

class ActionCommandSenderTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto why_not = tests::enter_private_network(); !why_not.empty()) GTEST_SKIP() << why_not;
  }
};

TEST_F(ActionCommandSenderTest, ReachesEveryCameraOnTheInterfaceAndCountsTheirAnswers) {
  ActionListener first("255.255.255.255", "127.0.0.1"), second("255.255.255.255", "127.0.0.2");
  ActionCommandSender sender({.interface_address = "127.0.0.1"});
  const ActionCommand command{.device_key = 1, .group_key = 2, .group_mask = 3, .at = RigClock::now()};
  const std::uint16_t id = sender.send(command);
  EXPECT_EQ(first.answer(0x0000), build_action_command(command, id));
  EXPECT_EQ(second.answer(0x8016), build_action_command(command, id));
  sender.collect_acks(std::chrono::seconds(5), 2);
  const auto acks = sender.acks();
  ASSERT_EQ(acks.size(), 2u);
  EXPECT_EQ(acks.at("127.0.0.1").accepted, 1u);
  EXPECT_EQ(acks.at("127.0.0.2").accepted, 0u);
  EXPECT_EQ(acks.at("127.0.0.2").late, 1u);
  EXPECT_EQ(sender.sent(), 1u);
}

TEST_F(ActionCommandSenderTest, TellsTheKindsOfRefusalApart) {
  ActionListener camera("127.0.0.1", "127.0.0.3");
  ActionCommandSender sender({.interface_address = "127.0.0.1", .destination = "127.0.0.1"});
  for (const ActionStatus status : {ActionStatus::success, ActionStatus::no_reference_time, ActionStatus::overflow,
                                    ActionStatus::late, ActionStatus::busy}) {
    sender.send({});
    camera.answer(static_cast<std::uint16_t>(status));
  }
  sender.collect_acks(std::chrono::seconds(5), 1);
  const auto counts = sender.acks().at("127.0.0.3");
  EXPECT_EQ(counts.accepted, 1u);
  EXPECT_EQ(counts.no_reference_time, 1u);
  EXPECT_EQ(counts.overflow, 1u);
  EXPECT_EQ(counts.late, 1u);
  EXPECT_EQ(counts.other_errors, 1u);
}

TEST_F(ActionCommandSenderTest, SaysWhenTheInterfaceIsNotThere) {
  EXPECT_THROW(ActionCommandSender({.interface_address = "eth0"}), InvalidInput);
  try {
    ActionCommandSender sender({.interface_address = "10.99.99.99"});
    FAIL() << "bound to an address that is not ours";
  } catch (const std::system_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("10.99.99.99"));
  }
}

}  // namespace
}  // namespace rotunda::capture
