#include "simulator/gige/gige_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "config/errors.h"
#include "tests/support/gige_device_bench.h"

namespace rotunda::simulator {
namespace {

using testing::ElementsAre;
using namespace std::chrono_literals;

constexpr std::uint16_t kOk = 0, kDenied = 0x8006;

}  // namespace

TEST(GigeDevice, DiscoveryTellsAddressSerialAndName) {
  Bench bench;
  const auto found = bench.send(GvcpOpcode::discovery, {});
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), kGvcpHeaderBytes + 0xF8);
  const std::span payload = std::span{*found}.subspan(kGvcpHeaderBytes);
  EXPECT_EQ(load_be<std::uint32_t>(payload, reg::kAddress), 0x7F000001U);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(&payload[0xD8])), "RS0000");
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(&payload[0xE8])), "cam00");
}

TEST(GigeDevice, OnlyTheControllerWritesAndOthersAreDenied) {
  Bench bench;
  EXPECT_EQ(bench.write(reg::kGain, 100), kDenied);  // nobody controls it yet
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2), kOk);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2, kTheirs), kDenied);
  EXPECT_EQ(bench.write(reg::kGain, 100, kTheirs), kDenied);
  EXPECT_EQ(bench.write(reg::kGain, 100), kOk);
  EXPECT_EQ(bench.status(bench.send(GvcpOpcode::read_register, words({reg::kGain}), kTheirs)), kOk);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 0), kOk);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 1, kTheirs), kOk);
  EXPECT_EQ(bench.status(bench.send(GvcpOpcode::read_register, words({reg::kGain}))), kDenied);  // exclusive
}

TEST(GigeDevice, AControllerThatFallsSilentLosesControlAndTheStreamStops) {
  Bench bench;
  bench.arm(TriggerSource::software);
  bench.now += 2s;
  bench.read(reg::kControlPrivilege);  // the heartbeat
  bench.device.check_heartbeat(kNow + 4s);
  EXPECT_TRUE(bench.device.has_controller());
  bench.device.check_heartbeat(kNow + 5s);
  EXPECT_FALSE(bench.device.has_controller());
  EXPECT_FALSE(bench.device.is_acquiring());
  EXPECT_EQ(bench.device.counts().lost_controllers, 1U);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2, kTheirs), kOk);
}

TEST(GigeDevice, WhoKnowsTheSwitchoverKeyTakesTheStreamOver) {
  Bench bench;
  bench.arm(TriggerSource::software);
  EXPECT_EQ(bench.write(reg::kSwitchoverKey, 0x1234), kOk);
  EXPECT_EQ(bench.read(reg::kSwitchoverKey), 0U);                                // nobody reads it
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 0x12340002, kTheirs), kDenied);  // not enabled
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 6), kOk);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 0x12350002, kTheirs), kDenied);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 0x12340002, kTheirs), kOk);
  EXPECT_TRUE(bench.device.is_acquiring());
  EXPECT_EQ(bench.read(reg::kPrimaryPort), kTheirs.port);
  EXPECT_EQ(bench.read(reg::kPrimaryAddress), kTheirs.address);
  EXPECT_EQ(bench.write(reg::kTriggerSoftware, 1), kDenied);
  EXPECT_EQ(bench.write(reg::kTriggerSoftware, 1, kTheirs), kOk);
}

TEST(GigeDevice, AControllerThatDisabledItsHeartbeatKeepsTheCamera) {
  Bench bench;
  bench.arm(TriggerSource::software);
  bench.write(reg::kGvcpConfiguration, bench.read(reg::kGvcpConfiguration) | kHeartbeatDisable);
  bench.device.check_heartbeat(kNow + 1h);
  EXPECT_TRUE(bench.device.has_controller());
}

TEST(GigeDevice, AnswersWhatTakesLongAtOnceAndAcknowledgesItWhenDone) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kUserSetSelector, 1);
  const auto save = gvcp_command(GvcpOpcode::write_memory, kAckWanted, 77, words({reg::kUserSetSave, 1}));
  const Bytes pending{0, 0, 0, 0x89, 0, 4, 0, 77, 0, 0, 0x04, 0xB0};  // 1200 ms
  EXPECT_EQ(bench.device.handle(save, kOurs, kNow), pending);
  EXPECT_EQ(bench.device.handle(save, kOurs, kNow + 500ms), pending);  // asked again: still at it
  EXPECT_FALSE(bench.device.take_late_acknowledgement(kNow + 1199ms));
  EXPECT_EQ(bench.device.next_late_acknowledgement(), kNow + 1200ms);
  const auto late = bench.device.take_late_acknowledgement(kNow + 1200ms);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->datagram, (Bytes{0, 0, 0, 0x87, 0, 4, 0, 77, 0, 0, 0, 4}));
  EXPECT_EQ(late->to, kOurs);
  EXPECT_EQ(bench.device.handle(save, kOurs, kNow + 2s), late->datagram);
  EXPECT_FALSE(bench.device.next_late_acknowledgement());
  EXPECT_EQ(bench.device.counts().pending_acks, 1U);
}

TEST(GigeDevice, WithoutPendingAckOnlyTheAcknowledgementComes) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kGvcpConfiguration, 0);
  bench.write(reg::kUserSetSelector, 1);
  EXPECT_FALSE(bench.send(GvcpOpcode::write_register, words({reg::kUserSetSave, 1})));
  EXPECT_TRUE(bench.device.take_late_acknowledgement(kNow + 2s));
}

TEST(GigeDevice, WriteRegisterAndWriteMemoryHaveTheSameEffect) {
  for (const auto opcode : {GvcpOpcode::write_register, GvcpOpcode::write_memory}) {
    Bench bench;
    bench.arm(TriggerSource::software);
    EXPECT_EQ(bench.status(bench.send(opcode, words({reg::kTriggerSoftware, 1}))), kOk);
    EXPECT_EQ(bench.starts_until(kNow + 1s), std::vector{kNow});
  }
}

TEST(GigeDevice, ARepeatedCommandIsAcknowledgedAgainButTriggersOnce) {
  Bench bench;
  bench.arm(TriggerSource::software);
  const auto datagram = gvcp_command(GvcpOpcode::write_register, kAckWanted, 999, words({reg::kTriggerSoftware, 1}));
  const auto once = bench.device.handle(datagram, kOurs, kNow);
  const auto again = bench.device.handle(datagram, kOurs, kNow + 500ms);
  EXPECT_EQ(once, again);
  EXPECT_EQ(bench.starts_until(kNow + 10s).size(), 1U);
}

TEST(GigeDevice, ExposuresStartWhenTheActionSaysWhateverOrderTheyCameIn) {
  Bench bench;
  bench.arm(TriggerSource::action1);
  EXPECT_EQ(bench.act(scheduled(kNow + 80ms)), kOk);
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms)), kOk);
  EXPECT_TRUE(bench.starts_until(kNow + 45ms).empty());  // exposed 5 ms, not read out yet
  EXPECT_THAT(bench.starts_until(kNow + 1s), ElementsAre(kNow + 40ms, kNow + 80ms));
}

TEST(GigeDevice, ALateActionIsToldAndCarriedOutWhenItCame) {
  Bench bench;
  bench.arm(TriggerSource::action1);
  EXPECT_EQ(bench.act(scheduled(kNow - 1ns)), 0x8016);
  EXPECT_THAT(bench.starts_until(kNow + 1s), ElementsAre(kNow));
  EXPECT_EQ(bench.device.counts().late_actions, 1U);
}

TEST(GigeDevice, ActionsForOthersAreNeitherAnsweredNorCarriedOut) {
  Bench bench;
  bench.arm(TriggerSource::action1);
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms, /*device_key=*/7)), 0xFFFF);
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms, 0, /*mask=*/2)), 0xFFFF);
  EXPECT_TRUE(bench.starts_until(kNow + 1s).empty());
  bench.write(reg::kActionGroupMask, 3);
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms, 0, 2)), kOk);
  EXPECT_EQ(bench.starts_until(kNow + 1s).size(), 1U);
}

TEST(GigeDevice, RefusesSchedulesItCannotKeep) {
  Bench bench;
  bench.arm(TriggerSource::action1);
  EXPECT_EQ(bench.act(scheduled(kNow + 1h)), 0x8002);
  EXPECT_EQ(bench.act(scheduled(Timestamp::max())), 0x8002);
  for (int k = 0; k < 16; ++k) EXPECT_EQ(bench.act(scheduled(kNow + (k + 1) * 40ms)), kOk);
  EXPECT_EQ(bench.act(scheduled(kNow + 1s)), 0x8015);
  bench.write(reg::kPtpEnable, 0);
  EXPECT_EQ(bench.act(scheduled(kNow + 2s)), 0x8013);
}

TEST(GigeDevice, TriggersDuringAnExposureOrOfAnotherSourceAreIgnored) {
  Bench bench;
  bench.arm(TriggerSource::action1);
  bench.act(scheduled(kNow + 40ms));
  bench.act(scheduled(kNow + 40ms));  // the same action, sent twice
  bench.act(scheduled(kNow + 42ms));
  bench.device.line0_edge(kNow + 60ms);
  EXPECT_THAT(bench.starts_until(kNow + 1s), ElementsAre(kNow + 40ms));
  EXPECT_EQ(bench.device.counts().ignored_triggers, 3U);
}

TEST(GigeDevice, FreeRunKeepsItsGridHoweverLateTheSenderLooks) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kHostPort, 6000);
  bench.write(reg::kFrameRate, 50'000);
  bench.write(reg::kAcquisitionStart, 1);
  EXPECT_THAT(bench.starts_until(kNow + 50ms), ElementsAre(kNow, kNow + 20ms, kNow + 40ms));
  EXPECT_THAT(bench.starts_until(kNow + 80ms), ElementsAre(kNow + 60ms));
}

TEST(GigeDevice, SingleAndMultiFrameAcquisitionsEndByThemselves) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kAcquisitionMode, 1);
  bench.write(reg::kAcquisitionStart, 1);
  EXPECT_EQ(bench.starts_until(kNow + 500ms).size(), 1U);
  bench.write(reg::kAcquisitionMode, 2);
  bench.write(reg::kFrameCount, 3);
  bench.write(reg::kAcquisitionStart, 1);
  EXPECT_EQ(bench.starts_until(kNow + 500ms).size(), 3U);
  EXPECT_FALSE(bench.device.is_acquiring());
}

TEST(GigeDevice, BlockIdsCountFromOneAndSkipZero) {
  Bench bench;
  bench.arm(TriggerSource::line0);
  for (int k = 0; k < 65536; ++k) {
    bench.device.line0_edge(kNow + k * 10ms);
    const auto frame = bench.device.take_due(kNow + k * 10ms + 9ms);
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->block, k % 65535 + 1);
  }
}

TEST(GigeDevice, LatchesTheMomentTheCommandCame) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kTimestampControl, 2);
  const auto latched =
      static_cast<std::uint64_t>(bench.read(reg::kTimestampHigh)) << 32 | bench.read(reg::kTimestampLow);
  EXPECT_EQ(static_cast<std::int64_t>(latched), kNow.time_since_epoch().count());
}

TEST(GigeDevice, RefusesValuesAndAddressesItDoesNotHave) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  EXPECT_EQ(bench.write(reg::kPixelFormat, 0x02180014), 0x8002);  // RGB8 from a Bayer sensor
  EXPECT_EQ(bench.write(reg::kPixelFormat, 0x01080001), kOk);
  EXPECT_EQ(bench.write(reg::kPacketSize, 100), 0x8002);
  EXPECT_EQ(bench.write(reg::kSensorWidth, 100), 0x8004);
  EXPECT_EQ(bench.write(0x80000000, 1), 0x8003);
  EXPECT_EQ(bench.write(reg::kGain + 1, 1), 0x8005);
  EXPECT_EQ(bench.status(bench.send(static_cast<GvcpOpcode>(0x4242), {})), 0x8001);
}

TEST(GigeDevice, FiresATestPacketOfTheSizeAskedFor) {
  Bench bench;
  bench.arm(TriggerSource::software);
  bench.write(reg::kPacketSize, kFireTestPacket | 9000);
  const auto packet = bench.device.take_test_packet();
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->bytes, 9000U - 28U);
  EXPECT_EQ(packet->destination, (Endpoint{kOurs.address, 6000}));
  EXPECT_EQ(bench.read(reg::kPacketSize), 9000U);
}

TEST(GigeDevice, ForceIpGrantsOnlyTheAddressTheCameraHas) {
  Bench bench;
  Bytes payload(56);
  store_be(std::span{payload}, 2, std::uint16_t{0x0252});
  store_be(std::span{payload}, 4, std::uint32_t{0x54000001});
  store_be(std::span{payload}, 20, std::uint32_t{0x7F000001});
  EXPECT_EQ(bench.status(bench.send(GvcpOpcode::force_ip, payload)), kOk);
  payload[23] = 9;
  EXPECT_EQ(bench.status(bench.send(GvcpOpcode::force_ip, payload)), 0x8001);
  payload[7] = 77;  // another camera's MAC
  EXPECT_FALSE(bench.send(GvcpOpcode::force_ip, payload));
}

TEST(GigeDevice, RefusesNamesThatDoNotFitItsRegisters) {
  EXPECT_THROW(GigeDevice({.name = "a name of twenty-odd letters"}, PtpStatus::slave, 1), InvalidInput);
  EXPECT_THROW(GigeDevice({.address = "localhost"}, PtpStatus::slave, 1), InvalidInput);
  EXPECT_THROW(GigeDevice({.width = 0}, PtpStatus::slave, 1), InvalidInput);
}

// Everything a client may say, cut short anywhere and with bits turned over. The sanitizers watch; what can be
// claimed is that the device still answers afterwards and never says more than it was asked for.
TEST(GigeDevice, SurvivesHostileDatagrams) {
  const std::vector<Bytes> honest{
      gvcp_command(GvcpOpcode::discovery, kAckWanted, 1, {}),
      gvcp_command(GvcpOpcode::force_ip, kAckWanted, 2, Bytes(56)),
      gvcp_command(GvcpOpcode::packet_resend, 0, 3, words({1, 0, 0xFFFFFF})),
      gvcp_command(GvcpOpcode::read_register, kAckWanted, 4, words({0xA00, 0x200000, 0xFFFFFFFC})),
      gvcp_command(GvcpOpcode::write_register, kAckWanted, 5, words({0xA00, 2, reg::kAcquisitionStart, 1})),
      gvcp_command(GvcpOpcode::read_memory, kAckWanted, 6, words({0x200000, 512})),
      gvcp_command(GvcpOpcode::write_memory, kAckWanted, 7, words({reg::kTriggerSoftware, 1})),
      gvcp_command(GvcpOpcode::write_memory, kAckWanted, 8, words({reg::kUserName, 1, 2, 3, 4, 5})),
      gvcp_command(GvcpOpcode::action, kAckWanted | kScheduledAction, 9, scheduled(kNow + 1s))};
  Bench bench;
  std::mt19937 random(7);
  const auto deliver = [&](std::span<const std::uint8_t> datagram) {
    bench.now += 100us;
    const auto acknowledgement = bench.device.handle(datagram, kOurs, bench.now);
    ASSERT_LE(acknowledgement.value_or(Bytes{}).size(), kGvcpHeaderBytes + kGvcpMaxReadBytes + 4);
    bench.starts_until(bench.now);
    while (bench.device.take_resend() || bench.device.take_test_packet()) continue;
  };
  for (const auto& datagram : honest) {
    for (std::size_t size = 0; size <= datagram.size(); ++size) deliver(std::span{datagram}.first(size));
    for (int k = 0; k < 3000; ++k) {
      Bytes mutant = datagram;
      for (int flips = 1 + k % 4; flips > 0; --flips)
        mutant[random() % mutant.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
      if (k % 2 == 0) store_be(std::span{mutant}, 4, static_cast<std::uint16_t>(mutant.size() - kGvcpHeaderBytes));
      deliver(mutant);
    }
  }
  EXPECT_TRUE(bench.send(GvcpOpcode::discovery, {}));
}

}  // namespace rotunda::simulator
