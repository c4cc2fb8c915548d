#include "simulator/gige/camera_clock.h"

#include <gtest/gtest.h>

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using namespace std::chrono_literals;

constexpr Timestamp kOn{1'000'000s};
const CameraClockOptions kReal{.ptp = false, .drift_ppm = 20.0, .wander = 100ns, .seed = 4};

}  // namespace

TEST(CameraClock, RunsFreeFromPowerUpAtItsCrystalsRate) {
  CameraClock clock(kReal, PtpStatus::slave, kOn);
  EXPECT_EQ(clock.reading(kOn), Timestamp{});
  EXPECT_EQ(clock.reading(kOn + 1000s), Timestamp{1000s + 20ms});
  EXPECT_EQ(clock.status(kOn + 1000s), PtpStatus::disabled);
  EXPECT_EQ(clock.true_time(Timestamp{1000s + 20ms}), kOn + 1000s);
  clock.reset(kOn + 1000s);
  EXPECT_EQ(clock.reading(kOn + 1001s), Timestamp{1s + 20us});
  EXPECT_EQ(clock.true_duration(1s), 1s - 20us);
}

TEST(CameraClock, ASlaveGoesThroughItsStatesAndConverges) {
  CameraClock clock(kReal, PtpStatus::slave, kOn);
  const Timestamp start = kOn + 100s;
  clock.enable_ptp(start);
  EXPECT_EQ(clock.status(start + 100ms), PtpStatus::initializing);
  EXPECT_EQ(clock.status(start + 500ms), PtpStatus::listening);
  EXPECT_LT(clock.reading(start + 500ms), Timestamp{200s});  // still its own time
  EXPECT_EQ(clock.status(start + 1300ms), PtpStatus::uncalibrated);
  EXPECT_GT(std::chrono::abs(clock.offset_from_master(start + 1300ms)), 10us);
  EXPECT_FALSE(clock.is_synchronised(start + 1300ms));
  EXPECT_EQ(clock.status(start + 4s), PtpStatus::slave);
  for (int k = 0; k < 200; ++k) {
    const Timestamp at = start + 10s + k * 37ms;
    EXPECT_LE(std::chrono::abs(clock.reading(at) - at), 101ns);
    EXPECT_EQ(clock.reading(at) - at, clock.offset_from_master(at));
    EXPECT_EQ(clock.reading(clock.true_time(at)), at);
  }
}

TEST(CameraClock, AMasterWaitsForABetterClockAndThenShowsTheRigsTime) {
  CameraClock clock(kReal, PtpStatus::master, kOn);
  clock.enable_ptp(kOn);
  EXPECT_EQ(clock.status(kOn + 2s), PtpStatus::listening);
  EXPECT_EQ(clock.status(kOn + 4s), PtpStatus::master);
  EXPECT_EQ(clock.reading(kOn + 4s), kOn + 4s);
  EXPECT_EQ(clock.offset_from_master(kOn + 4s), 0ns);
}

TEST(CameraClock, DriftsAwayFromWhereItWasOncePtpIsOff) {
  CameraClock clock(kReal, PtpStatus::slave, kOn);
  clock.enable_ptp(kOn);
  const Timestamp off = kOn + 60s;
  const auto left = clock.reading(off) - off;
  clock.disable_ptp(off);
  clock.reset(off - 1s + 1s);  // free running: a reset works
  EXPECT_EQ(clock.reading(off), Timestamp{});
  clock = CameraClock(kReal, PtpStatus::slave, kOn);
  clock.enable_ptp(kOn);
  clock.reset(off);  // disciplined: it does not
  clock.disable_ptp(off);
  EXPECT_EQ(clock.reading(off + 50s) - (off + 50s), left + 1ms);
}

TEST(CameraClock, WithoutOptionsIsIdealOnceSynchronised) {
  const CameraClock clock({}, PtpStatus::slave, kOn);
  EXPECT_TRUE(clock.is_synchronised(kOn + 2s));
  EXPECT_EQ(clock.reading(kOn + 2s), kOn + 2s);
}

TEST(CameraClock, RealisticClocksDifferAndStayWithinTheirBounds) {
  const auto one = realistic_clock(1), other = realistic_clock(2);
  EXPECT_NE(one.drift_ppm, other.drift_ppm);
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    EXPECT_LE(std::abs(realistic_clock(seed).drift_ppm), 25.0);
    EXPECT_LE(realistic_clock(seed).wander, 120ns);
    EXPECT_GE(realistic_clock(seed).wander, 20ns);
  }
}

}  // namespace rotunda::simulator
