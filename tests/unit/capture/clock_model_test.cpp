#include "capture/sync/clock_model.h"

#include <gtest/gtest.h>

#include <random>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// A device whose clock shows 5 s when the rig's shows 1000 s, and runs fast by so much.
struct DriftingDevice {
  double fast_ppm = 0.0;
  DeviceTime at(Timestamp rig) const {
    const nanoseconds since = rig - Timestamp(1000s);
    return 5s + since + nanoseconds(std::llround(fast_ppm * 1e-6 * static_cast<double>(since.count())));
  }
};

// Four readings a second for `seconds`, answered after 20 to 60 us; one in ten is held up on the way back.
ClockModel observed(const DriftingDevice& device, double seconds, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> way_us(10, 30), held_us(500, 8000), tenth(0, 9);
  ClockModel model;
  for (double t = 0.0; t < seconds; t += 0.25) {
    const Timestamp asked = Timestamp(1000s) + nanoseconds(static_cast<std::int64_t>(t * 1e9));
    const Timestamp device_moment = asked + std::chrono::microseconds(way_us(random));
    Timestamp answered = device_moment + std::chrono::microseconds(way_us(random));
    if (tenth(random) == 0) answered += std::chrono::microseconds(held_us(random));
    model.add({asked, answered, device.at(device_moment)});
  }
  return model;
}

TEST(ClockModel, TellsRigTimeToTheBracketWhateverTheDrift) {
  for (const double ppm : {-80.0, 0.0, 35.0, 150.0}) {
    const DriftingDevice device{ppm};
    const auto model = observed(device, 16.0, 7);
    EXPECT_NEAR(model.drift_ppm(), ppm, 1.5) << "10 us of error over 16 s are 0.6 ppm";
    for (const auto rig : {Timestamp(1001s), Timestamp(1010s), Timestamp(1018s)}) {
      EXPECT_LT(std::chrono::abs(model.rig_time(device.at(rig)) - rig), 15us) << ppm;
      EXPECT_LT(std::chrono::abs(model.device_time(rig) - device.at(rig)), 15us) << ppm;
    }
    EXPECT_LE(model.error(), 30us);
  }
}

TEST(ClockModel, ThereAndBackIsTheSameMoment) {
  const auto model = observed({120.0}, 10.0, 3);
  const Timestamp moment = Timestamp(1007s) + 123456789ns;
  EXPECT_LE(std::chrono::abs(model.rig_time(model.device_time(moment)) - moment), 1ns);
}

TEST(ClockModel, OneReadingGivesTheOffsetAlone) {
  ClockModel model;
  model.add({Timestamp(10s), Timestamp(10s) + 40us, 3s});
  EXPECT_EQ(model.rig_time(3s), Timestamp(10s) + 20us);
  EXPECT_EQ(model.rig_time(4s), Timestamp(11s) + 20us);
  EXPECT_EQ(model.error(), 20us);
}

TEST(ClockModel, ADeviceThatWasRestartedIsLearntAnew) {
  auto model = observed({20.0}, 8.0, 1);
  EXPECT_EQ(model.resets(), 0U);
  model.add({Timestamp(1020s), Timestamp(1020s) + 40us, 100ms});
  EXPECT_EQ(model.resets(), 1U);
  EXPECT_EQ(model.rig_time(100ms), Timestamp(1020s) + 20us);
}

TEST(ClockModel, RefusesWhatCannotBe) {
  ClockModel model;
  EXPECT_THROW(model.rig_time(0ns), InvalidInput);
  EXPECT_THROW(model.device_time(Timestamp(1s)), InvalidInput);
  EXPECT_THROW(model.add({Timestamp(2s), Timestamp(1s), 0ns}), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
