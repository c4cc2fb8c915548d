#include "rig/daemon/camera_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;
using testing::Optional;

TEST(FrameRate, IsThatOfTheLastSecond) {
  FrameRate rate;
  const std::chrono::steady_clock::time_point start{100s};
  EXPECT_EQ(rate.measure(0, start), 0.0);
  EXPECT_EQ(rate.measure(10, start + 400ms), 0.0) << "too short to say";
  EXPECT_DOUBLE_EQ(rate.measure(25, start + 1s), 25.0);
  for (std::uint64_t k = 1; k <= 40; ++k) rate.measure(25 + k, start + 1s + k * 100ms);
  EXPECT_NEAR(rate.measure(65, start + 5s), 10.0, 1e-9) << "what was before is forgotten";
  EXPECT_EQ(rate.measure(3, start + 6s), 0.0) << "opened anew";
  rate.forget();
  EXPECT_EQ(rate.measure(4, start + 7s), 0.0);
}

TEST(CameraStatus, TellsTheClockInMicrosecondsAndNothingOfWhatIsNotKnown) {
  CameraStatus status;
  capture::SourceHealth health;
  health.clock.kind = "ptp slave";
  health.clock.offset = -1500ns;
  health.temperature_c = 41.5;
  tell_health(status, health);
  EXPECT_THAT(status.clock, Optional(std::string("ptp slave")));
  EXPECT_THAT(status.clock_offset_us, Optional(-1.5));
  EXPECT_EQ(status.clock_error_us, std::nullopt);
  EXPECT_THAT(status.temperature_c, Optional(41.5));
  tell_health(status, {});
  EXPECT_EQ(status.clock, std::nullopt);
  EXPECT_EQ(status.clock_offset_us, std::nullopt);
  EXPECT_EQ(status.temperature_c, std::nullopt);
}

TEST(CameraStatus, TellsSilenceBeforeAllElseThatIsWrong) {
  capture::SourceDescription description;
  capture::SourceHealth health;
  EXPECT_EQ(problems_of(description, health, false, ""), "");
  description.warnings = {"w"};
  health.problem = "p";
  health.clock.problem = "c";
  EXPECT_EQ(problems_of(description, health, false, "a"), "w; a; p; c");
  EXPECT_THAT(problems_of(description, health, true, ""), testing::StartsWith("sends no pictures"));
}

}  // namespace
}  // namespace rotunda::rig
