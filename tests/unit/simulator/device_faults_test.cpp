// What goes wrong with the camera itself, on the pure state machine. Every claim stands beside the counter that must
// have moved, and what the same camera does without the fault.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/gige_device_bench.h"

namespace rotunda::simulator {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr std::uint16_t kOk = 0, kDenied = 0x8006, kSilence = 0xFFFF;

class DeviceFaults : public testing::Test {
 protected:
  DeviceFaults() { bench.arm(TriggerSource::action1); }

  void add(const FaultEffect& effect, std::optional<std::chrono::nanoseconds> lasts = {}) {
    bench.device.faults().add({.effect = effect, .lasts = lasts}, bench.now);
  }
  // The exposures of four triggers, 40 ms apart, in units of their distance to the first.
  std::vector<Timestamp> four_triggers() {
    for (int k = 0; k < 4; ++k) EXPECT_EQ(bench.act(scheduled(bench.now + (k + 1) * 40ms)), kOk);
    bench.now += 1s;
    return bench.starts_until(bench.now);
  }
  std::uint64_t fired(FaultKind kind) { return bench.device.counts().faults[kind]; }
  FaultCounts all_fired() { return bench.device.counts().faults; }

  Bench bench;
};

}  // namespace

TEST_F(DeviceFaults, NothingFiresWithoutAFault) {
  EXPECT_THAT(four_triggers(), ElementsAre(kNow + 40ms, kNow + 80ms, kNow + 120ms, kNow + 160ms));
  EXPECT_EQ(all_fired().fired, FaultCounts{}.fired);
}

TEST_F(DeviceFaults, MissedTriggersLeaveNoExposure) {
  bench.device.faults().add({.effect = MissedTrigger{.every = 1}, .triggers = 2}, bench.now);
  EXPECT_THAT(four_triggers(), ElementsAre(kNow + 120ms, kNow + 160ms));
  EXPECT_EQ(fired(FaultKind::missed_trigger), 2U);
  add(MissedTrigger{.every = 3});  // of all since serving began: the sixth
  EXPECT_EQ(four_triggers().size(), 3U);
  EXPECT_EQ(fired(FaultKind::missed_trigger), 3U);
}

TEST_F(DeviceFaults, AMissedActionSentTwiceStaysMissed) {
  bench.device.faults().add({.effect = MissedTrigger{.every = 1}, .triggers = 1}, bench.now);
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms)), kOk);
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms)), kOk);
  EXPECT_THAT(bench.starts_until(kNow + 1s), IsEmpty());
}

TEST_F(DeviceFaults, LateTriggersExposeLater) {
  add(LateTrigger{.by = 7ms}, 100ms);
  EXPECT_THAT(four_triggers(), ElementsAre(kNow + 47ms, kNow + 87ms, kNow + 120ms, kNow + 160ms));
  EXPECT_EQ(fired(FaultKind::late_trigger), 2U);
}

TEST_F(DeviceFaults, DoubledTriggersExposeTwice) {
  bench.device.faults().add({.effect = DoubledTrigger{.every = 1, .after = 9ms}, .triggers = 1}, bench.now);
  EXPECT_THAT(four_triggers(), ElementsAre(kNow + 40ms, kNow + 49ms, kNow + 80ms, kNow + 120ms, kNow + 160ms));
  EXPECT_EQ(fired(FaultKind::doubled_trigger), 1U);
  add(DoubledTrigger{.every = 1, .after = 2ms});  // during the exposure: no camera can
  EXPECT_EQ(four_triggers().size(), 4U);
  EXPECT_EQ(fired(FaultKind::doubled_trigger), 1U);
}

TEST_F(DeviceFaults, ASilentCameraHearsNothingUntilItIsBack) {
  add(Silence{}, 2s);
  EXPECT_EQ(bench.write(reg::kGain, 100), kSilence);
  EXPECT_FALSE(bench.send(GvcpOpcode::discovery, {}));
  EXPECT_EQ(fired(FaultKind::silence), 2U);
  bench.now += 2s;
  EXPECT_EQ(bench.write(reg::kGain, 100), kOk);
  EXPECT_EQ(fired(FaultKind::silence), 2U);
}

TEST_F(DeviceFaults, ARebootTakesControlAndSettingsAndComesBack) {
  bench.write(reg::kGain, 700);
  add(Reboot{}, 5s);
  EXPECT_FALSE(bench.send(GvcpOpcode::discovery, {}));
  EXPECT_FALSE(bench.device.is_acquiring());
  EXPECT_FALSE(bench.device.has_controller());
  bench.now += 5s;
  EXPECT_TRUE(bench.send(GvcpOpcode::discovery, {}));
  EXPECT_EQ(bench.read(reg::kGain), 0U);
  EXPECT_EQ(bench.read(reg::kControlPrivilege), 0U);
  EXPECT_EQ(bench.write(reg::kGain, 1), kDenied);
  EXPECT_EQ(fired(FaultKind::reboot), 1U);
  bench.arm(TriggerSource::action1);
  EXPECT_EQ(four_triggers().size(), 4U);
}

TEST_F(DeviceFaults, StolenControlDeniesTheControllerUntilItIsGivenBack) {
  add(ControlStolen{}, 2s);
  EXPECT_EQ(bench.write(reg::kGain, 100), kDenied);
  EXPECT_EQ(bench.status(bench.send(GvcpOpcode::read_register, words({reg::kGain}))), kDenied);
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2), kDenied);
  EXPECT_FALSE(bench.device.is_acquiring());
  bench.now += 1900ms;
  bench.device.check_heartbeat(bench.now);
  EXPECT_TRUE(bench.device.has_controller());
  bench.now += 100ms;
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2), kOk);
  EXPECT_EQ(fired(FaultKind::control_stolen), 1U);
  add(ControlStolen{.exclusive = false}, 1s);
  EXPECT_EQ(bench.read(reg::kControlPrivilege), 2U);
}

TEST_F(DeviceFaults, SlowRegistersAcknowledgeLaterAndInTheOrderOfTime) {
  bench.write(reg::kGvcpConfiguration, 0);  // no PENDING_ACK
  add(SlowRegisters{.by = 300ms}, 100ms);
  EXPECT_FALSE(bench.send(GvcpOpcode::read_register, words({reg::kGain})));
  EXPECT_TRUE(bench.send(GvcpOpcode::discovery, {})) << "registers only";
  EXPECT_EQ(bench.device.next_late_acknowledgement(), kNow + 300ms);
  EXPECT_FALSE(bench.device.take_late_acknowledgement(kNow + 299ms));
  const auto late = bench.device.take_late_acknowledgement(kNow + 300ms);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->to, kOurs);
  EXPECT_EQ(bench.status(late->datagram), kOk);
  EXPECT_EQ(fired(FaultKind::slow_registers), 1U);
  bench.now += 100ms;
  EXPECT_EQ(bench.write(reg::kGain, 100), kOk);
  EXPECT_EQ(fired(FaultKind::slow_registers), 1U);
}

TEST_F(DeviceFaults, SlowRegistersSayPendingToWhoUnderstandsIt) {
  EXPECT_EQ(bench.write(reg::kGvcpConfiguration, kPendingAckEnable), kOk);
  add(SlowRegisters{.by = 300ms});
  const auto pending = bench.send(GvcpOpcode::read_register, words({reg::kGain}));
  ASSERT_TRUE(pending);
  EXPECT_EQ(load_be<std::uint16_t>(*pending, 2), 0x0089);
  EXPECT_EQ(load_be<std::uint16_t>(*pending, kGvcpHeaderBytes + 2), 300);
  EXPECT_TRUE(bench.device.take_late_acknowledgement(kNow + 300ms));
}

TEST_F(DeviceFaults, AClearedTheftGivesControlBack) {
  add(ControlStolen{});
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2), kDenied);
  bench.device.faults().clear();
  EXPECT_EQ(bench.write(reg::kControlPrivilege, 2), kOk);
}

TEST_F(DeviceFaults, AStalledStreamGivesNoFramesWhileTheControlChannelAnswers) {
  add(Stall{}, 100ms);
  EXPECT_THAT(four_triggers(), ElementsAre(kNow + 120ms, kNow + 160ms));
  EXPECT_EQ(fired(FaultKind::stall), 2U);
  EXPECT_EQ(bench.device.counts().triggers, 4U);
  EXPECT_TRUE(bench.device.is_acquiring());
}

TEST_F(DeviceFaults, PayloadSizeTellsOtherBytesThanAFrameHas) {
  const auto honest = bench.read(reg::kPayloadSize);
  add(WrongPayloadSize{.register_change = -4096}, 1s);
  EXPECT_EQ(bench.read(reg::kPayloadSize), honest - 4096);
  const auto memory = bench.send(GvcpOpcode::read_memory, words({reg::kPixelFormat, 8}));
  EXPECT_EQ(load_be<std::uint32_t>(*memory, kGvcpHeaderBytes + 8), honest - 4096);
  EXPECT_EQ(fired(FaultKind::wrong_payload_size), 2U);
  bench.now += 1s;
  EXPECT_EQ(bench.read(reg::kPayloadSize), honest);
}

TEST_F(DeviceFaults, TemperatureRisesAndStopsTheStreamWhereItIsToldTo) {
  const auto usual = bench.read(reg::kTemperature);
  add(OverTemperature{.celsius = 91.5, .within = 10s, .stops_at = 80.0});
  bench.now += 5s;
  EXPECT_NEAR(bench.read(reg::kTemperature), (usual + 91'500) / 2, 500);
  EXPECT_EQ(four_triggers().size(), 4U);
  bench.now += 4s;
  EXPECT_EQ(bench.read(reg::kTemperature), 91'500U);
  EXPECT_THAT(four_triggers(), IsEmpty());
  EXPECT_EQ(fired(FaultKind::over_temperature), 1U + 4U);
  bench.device.faults().clear();
  EXPECT_NEAR(bench.read(reg::kTemperature), usual, 1000);  // it has streamed
  EXPECT_EQ(four_triggers().size(), 4U);
}

TEST_F(DeviceFaults, AClockThatIsAheadStampsLaterAndActsEarlier) {
  add(ClockStep{.by = 3ms});
  EXPECT_EQ(bench.act(scheduled(kNow + 40ms)), kOk);
  const auto frame = bench.device.take_due(kNow + 1s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->exposure_start, kNow + 37ms);
  EXPECT_EQ(frame->stamp, kNow + 40ms);
  EXPECT_EQ(fired(FaultKind::clock_step), 1U);
  bench.write(reg::kTimestampControl, 2);
  const auto latched =
      static_cast<std::uint64_t>(bench.read(reg::kTimestampHigh)) << 32 | bench.read(reg::kTimestampLow);
  EXPECT_EQ(static_cast<std::int64_t>(latched), (bench.now + 3ms).time_since_epoch().count());
}

TEST_F(DeviceFaults, ADriftingClockGainsByTheSecond) {
  add(ClockDrift{.ppm = 100.0});
  bench.write(reg::kTriggerSource, static_cast<std::uint32_t>(TriggerSource::line0));
  bench.device.line0_edge(kNow + 10s);
  const auto frame = bench.device.take_due(kNow + 11s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->exposure_start, kNow + 10s);
  EXPECT_EQ(frame->stamp, kNow + 10s + 1ms);
  EXPECT_EQ(fired(FaultKind::clock_drift), 1U);
}

TEST_F(DeviceFaults, OfFreeRunCountTheExposures) {
  bench.write(reg::kTriggerMode, 0);
  bench.device.faults().add({.effect = Stall{}, .at_trigger = 2, .triggers = 1}, bench.now);
  EXPECT_THAT(bench.starts_until(kNow + 100ms), ElementsAre(kNow, kNow + 80ms));
  EXPECT_EQ(fired(FaultKind::stall), 1U);
}

}  // namespace rotunda::simulator
