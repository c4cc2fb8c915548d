#include "simulator/gige/simulated_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simulator/gige/chunk_data.h"
#include "tests/support/gige_device_bench.h"

namespace rotunda::simulator {
namespace {

using testing::ElementsAre;
using namespace std::chrono_literals;

constexpr std::uint16_t kOk = 0, kBadValue = 0x8002, kReadOnly = 0x8004, kDenied = 0x8006, kNoTime = 0x8013;
const CameraClockOptions kRealClock{.ptp = false, .drift_ppm = 20.0, .wander = 100ns, .seed = 3};

Bench camera_with(const CameraClockOptions& clock, PtpStatus role = PtpStatus::slave) {
  GigeCameraOptions options;
  options.clock = clock;
  return {.device = GigeDevice(options, role, 50000, kNow - 100s)};
}

std::int64_t latched(Bench& bench) {
  bench.write(reg::kTimestampControl, 2);
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(bench.read(reg::kTimestampHigh)) << 32 |
                                   bench.read(reg::kTimestampLow));
}

std::int64_t offset_from_master(Bench& bench) {
  bench.write(reg::kPtpDataSetLatch, 1);
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(bench.read(reg::kPtpOffset)) << 32 |
                                   bench.read(reg::kPtpOffset + 4));
}

PtpStatus ptp_status(Bench& bench) {
  return static_cast<PtpStatus>(bench.read(reg::kPtpStatus));
}

}  // namespace

TEST(SimulatedCamera, StampsAndLatchesInItsOwnClockWhilePtpIsOff) {
  auto bench = camera_with(kRealClock);
  bench.arm(TriggerSource::software);
  EXPECT_EQ(ptp_status(bench), PtpStatus::disabled);
  EXPECT_EQ(latched(bench), 100'002'000'000);  // 100 s since power-up, and 20 ppm of it
  bench.write(reg::kTriggerSoftware, 1);
  const auto frame = bench.device.take_due(kNow + 1s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->exposure_start, kNow);
  EXPECT_EQ(frame->stamp, Timestamp{100'002'000'000ns});
  EXPECT_EQ(bench.act(scheduled(kNow + 1s)), kNoTime);
  bench.write(reg::kTimestampControl, 1);
  EXPECT_EQ(latched(bench), 0);
}

TEST(SimulatedCamera, ConvergesToTheRigsTimeOncePtpIsOn) {
  auto bench = camera_with(kRealClock);
  bench.arm(TriggerSource::action1);
  bench.write(reg::kPtpEnable, 1);
  EXPECT_EQ(ptp_status(bench), PtpStatus::initializing);
  bench.now = kNow + 1s;
  EXPECT_EQ(ptp_status(bench), PtpStatus::listening);
  bench.now = kNow + 1300ms;
  EXPECT_EQ(ptp_status(bench), PtpStatus::uncalibrated);
  EXPECT_GT(std::abs(offset_from_master(bench)), 10'000);
  EXPECT_EQ(bench.act(scheduled(bench.now + 1s)), kNoTime);
  bench.now = kNow + 10s;
  bench.read(reg::kControlPrivilege);
  EXPECT_EQ(ptp_status(bench), PtpStatus::slave);
  EXPECT_LE(std::abs(offset_from_master(bench)), 101);
  EXPECT_NEAR(static_cast<double>(latched(bench) - bench.now.time_since_epoch().count()), 0.0, 101.0);
  EXPECT_EQ(bench.act(scheduled(bench.now + 40ms)), kOk);
  const auto frame = bench.device.take_due(bench.now + 1s);
  ASSERT_TRUE(frame);
  EXPECT_NEAR(static_cast<double>((frame->stamp - (bench.now + 40ms)).count()), 0.0, 1.0);  // when its clock shows it
  EXPECT_LE(std::chrono::abs(frame->exposure_start - (bench.now + 40ms)), 101ns);
}

TEST(SimulatedCamera, PtpIsOneSwitchInTheFeatureAndTheBootstrapRegister) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  const auto configuration = bench.read(reg::kGvcpConfiguration);
  EXPECT_NE(configuration & kPtpConfigured, 0U);
  bench.write(reg::kGvcpConfiguration, configuration & ~kPtpConfigured);
  EXPECT_EQ(bench.read(reg::kPtpEnable), 0U);
  bench.write(reg::kPtpEnable, 1);
  EXPECT_EQ(bench.read(reg::kGvcpConfiguration), configuration);
}

TEST(SimulatedCamera, FreeRunGoesAtTheRateOfItsCrystal) {
  auto bench = camera_with({.ptp = false, .drift_ppm = 100.0});
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kAcquisitionStart, 1);
  EXPECT_THAT(bench.starts_until(kNow + 50ms), ElementsAre(kNow, kNow + 40ms - 4us));  // 100 ppm fast
}

TEST(SimulatedCamera, LineEdgesTriggerByActivationDelayAndDebouncer) {
  Bench bench;
  bench.arm(TriggerSource::line0);
  bench.device.set_line0(true, kNow + 10ms);
  bench.device.set_line0(false, kNow + 40ms);
  EXPECT_EQ(bench.device.next_due(), kNow + 10ms);
  EXPECT_THAT(bench.starts_until(kNow + 100ms), ElementsAre(kNow + 10ms));
  bench.write(reg::kTriggerActivation, static_cast<std::uint32_t>(TriggerActivation::falling_edge));
  bench.write(reg::kTriggerDelay, 3'000'000);
  bench.write(reg::kLineDebounce, 50'000);
  bench.device.set_line0(true, kNow + 110ms);
  bench.device.set_line0(false, kNow + 110ms + 20us);  // bounces
  bench.device.set_line0(true, kNow + 110ms + 30us);
  bench.device.set_line0(false, kNow + 120ms);
  EXPECT_THAT(bench.starts_until(kNow + 200ms), ElementsAre(kNow + 120ms + 50us + 3ms));
  bench.now = kNow + 115ms;
  EXPECT_EQ(bench.read(reg::kLineStatus), 1U);
  bench.now = kNow + 121ms;
  EXPECT_EQ(bench.read(reg::kLineStatus), 0U);
}

TEST(SimulatedCamera, ARegionFitsTheSensorAndChangesThePayload) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  EXPECT_EQ(bench.read(reg::kPayloadSize), 720U * 576U);
  EXPECT_EQ(bench.write(reg::kOffsetX, 2), kBadValue);  // the width is still the sensor's
  EXPECT_EQ(bench.write(reg::kWidth, 640), kOk);
  EXPECT_EQ(bench.write(reg::kHeight, 480), kOk);
  EXPECT_EQ(bench.write(reg::kOffsetX, 80), kOk);
  EXPECT_EQ(bench.write(reg::kOffsetX, 82), kBadValue);
  EXPECT_EQ(bench.write(reg::kOffsetX, 41), kBadValue);  // would turn the mosaic
  EXPECT_EQ(bench.write(reg::kWidth, 642), kBadValue);
  EXPECT_EQ(bench.write(reg::kWidth, 12), kBadValue);
  EXPECT_EQ(bench.write(reg::kWidth, 0xFFFFFFFC), kBadValue);
  EXPECT_EQ(bench.read(reg::kPayloadSize), 640U * 480U);
  bench.write(reg::kAcquisitionStart, 1);
  EXPECT_EQ(bench.write(reg::kWidth, 320), kDenied);  // locked
  const auto frame = bench.device.take_due(kNow + 20ms);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width, 640U);
  EXPECT_EQ(frame->offset_x, 80U);
}

TEST(SimulatedCamera, ChunksTellTheExposureTheyFollow) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kChunkModeActive, 1);
  bench.write(reg::kChunkEnable + 4 * static_cast<std::uint32_t>(Chunk::gain), 1);
  const std::size_t expected = chunk_data_bytes(720 * 576, 0b10111);
  EXPECT_EQ(bench.read(reg::kPayloadSize), 720U * 576U + expected);
  bench.device.set_line0(true, kNow - 1ms);
  bench.arm(TriggerSource::software);
  bench.write(reg::kExposureTime, 2'345'000);
  bench.write(reg::kTriggerSoftware, 1);
  const auto frame = bench.device.take_due(kNow + 1s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->chunks, chunk_data(720 * 576, {.enabled = 0b10111,
                                                  .exposure_start = kNow,
                                                  .exposure = 2345us,
                                                  .line_status = 1,
                                                  .frame_id = 1,
                                                  .gain = 0}));
}

TEST(SimulatedCamera, UserSetsOutliveThePower) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  bench.write(reg::kExposureTime, 7'000'000);
  bench.write(reg::kUserName, 0x6C656674);                  // "left"
  EXPECT_EQ(bench.write(reg::kUserSetSave, 1), kReadOnly);  // the factory's
  bench.write(reg::kUserSetSelector, 2);
  EXPECT_EQ(bench.write(reg::kUserSetLoad, 1), kBadValue);  // nothing in it yet
  bench.write(reg::kUserSetSave, 1);
  bench.write(reg::kUserSetSelector, 0);
  bench.write(reg::kUserSetLoad, 1);
  EXPECT_EQ(bench.read(reg::kExposureTime), 5'000'000U);
  bench.write(reg::kUserSetSelector, 2);
  bench.write(reg::kUserSetLoad, 1);
  EXPECT_EQ(bench.read(reg::kExposureTime), 7'000'000U);
  bench.write(reg::kExposureTime, 9'000'000);  // not saved
  bench.write(reg::kUserSetDefault, 2);
  bench.device.faults().add({.effect = Reboot{}, .lasts = 1s}, kNow + 1s);
  bench.now = kNow + 3s;
  EXPECT_EQ(bench.read(reg::kExposureTime), 7'000'000U);
  EXPECT_EQ(bench.read(reg::kUserSetSelector), 2U);
  EXPECT_EQ(bench.read(reg::kUserName), 0x6C656674U);
  EXPECT_EQ(bench.read(reg::kControlPrivilege), 0U);
}

TEST(SimulatedCamera, ARebootedCameraLooksForItsMasterAgain) {
  Bench bench;
  bench.device.faults().add({.effect = Reboot{}, .lasts = 500ms}, kNow);
  bench.now = kNow + 600ms;
  EXPECT_EQ(ptp_status(bench), PtpStatus::listening);
  bench.now = kNow + 5s;
  EXPECT_EQ(ptp_status(bench), PtpStatus::slave);
}

TEST(SimulatedCamera, GetsWarmWhileItStreamsAndCoolsAgain) {
  Bench bench;
  const auto idle = bench.read(reg::kTemperature);
  bench.arm(TriggerSource::software);
  bench.now = kNow + 420s;  // one time constant
  bench.device.check_heartbeat(kNow);
  const auto warm = bench.read(reg::kTemperature);
  EXPECT_NEAR(warm - idle, 12'500 * (1 - std::exp(-1.0)), 2.0);
  bench.write(reg::kAcquisitionStop, 1);
  bench.now = kNow + 2h;
  EXPECT_NEAR(bench.read(reg::kTemperature), idle, 2.0);
}

TEST(SimulatedCamera, ExtendedIdsCountPast16Bits) {
  Bench bench;
  bench.write(reg::kControlPrivilege, 2);
  EXPECT_EQ(bench.write(reg::kGvspConfiguration, kExtendedIdEnable), kOk);
  bench.arm(TriggerSource::line0);
  EXPECT_EQ(bench.write(reg::kGvspConfiguration, 0), kDenied);
  for (std::uint64_t k = 1; k <= 65537; ++k) {
    const Timestamp at = kNow + k * 10ms;
    bench.device.line0_edge(at);
    const auto frame = bench.device.take_due(at + 9ms);
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->block, k);
    ASSERT_TRUE(frame->extended_ids);
  }
}

}  // namespace rotunda::simulator
