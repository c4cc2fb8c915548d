#include "capture/base/host_clock.h"

#include <gtest/gtest.h>

#include <ctime>

#include "capture/frame.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;

TEST(RigClock, IsThisMachinesTaiWhileNobodySetsIt) {
  const auto clocks = read_host_clocks();
  const auto now = RigClock::now().time_since_epoch();
  EXPECT_LT(std::chrono::abs(now - clocks.tai), 1s);
  EXPECT_LT(std::chrono::abs(host_clock_ahead()), kSmallestClockStep);
  follow_host_clock();
  EXPECT_LT(std::chrono::abs(host_clock_ahead()), kSmallestClockStep);
  auto last = RigClock::now();
  for (int i = 0; i < 1000; ++i) {
    const auto next = RigClock::now();
    ASSERT_LE(last, next);
    last = next;
  }
}

TEST(ClockStepWatch, TellsEveryStepOnceWithItsSignAndNothingElse) {
  HostClocks clocks{.tai = 1'700'000'000s, .boot = 500s};
  const auto pass = [&](std::chrono::nanoseconds time) {
    clocks.tai += time;
    clocks.boot += time;
  };
  ClockStepWatch watch([&] { return clocks; });
  EXPECT_FALSE(watch.look());
  pass(3600s);
  EXPECT_FALSE(watch.look()) << "time that passes is no step";
  clocks.tai += 200us;
  EXPECT_FALSE(watch.look()) << "nor is what two readings differ by";
  clocks.tai += 37s;
  pass(20ms);
  EXPECT_EQ(watch.look(), 37s + 200us);
  EXPECT_FALSE(watch.look()) << "told once";
  clocks.tai -= 2h;
  EXPECT_EQ(watch.look(), -2h);
}

}  // namespace
}  // namespace rotunda::capture
