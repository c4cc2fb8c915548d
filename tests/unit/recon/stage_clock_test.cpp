#include "recon/stage_clock.h"

#include <gtest/gtest.h>

#include <thread>

namespace rotunda::recon {

TEST(StageClock, CountsEveryRunUnderItsStage) {
  StageClock clock;
  EXPECT_EQ(clock.run("carve", [] { return 3; }), 3);
  clock.run("carve", [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
  StageClock::Laps laps(clock, "draw");
  for (int i = 0; i < 3; ++i) laps.lap();
  const auto costs = clock.costs();
  ASSERT_EQ(costs.size(), 2U);
  EXPECT_EQ(costs[0].stage, "carve");
  EXPECT_EQ(costs[0].count, 2U);
  EXPECT_GE(costs[0].median_ms, 20.0);      // the larger of two
  EXPECT_LT(costs[0].median_cpu_ms, 20.0);  // sleeping costs none
  EXPECT_EQ(costs[1].count, 3U);
}

}  // namespace rotunda::recon
