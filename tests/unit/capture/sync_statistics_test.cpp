#include "capture/sync/sync_statistics.h"

#include <gtest/gtest.h>

#include <random>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

FrameSet set_at(std::uint64_t trigger, const std::vector<std::optional<nanoseconds>>& offsets) {
  FrameSet set{.trigger = trigger, .time = Timestamp(1000s) + static_cast<int>(trigger) * 40ms, .slots = {}};
  for (const auto& offset : offsets) {
    FrameSlot slot{.frame = std::nullopt, .missing_because = HoleReason::late};
    if (offset) {
      slot.frame.emplace();
      slot.frame->exposure_start = set.time + *offset;
    }
    set.slots.push_back(slot);
  }
  return set;
}

TEST(SyncStatistics, FindsOffsetDriftAndJitterOfEveryCamera) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 2000.0);
  SyncStatistics statistics(3);
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const double seconds = 0.04 * static_cast<double>(k);
    const auto drifting = nanoseconds(static_cast<std::int64_t>(5e3 + 12e3 * seconds + noise(random)));  // 12 ppm
    statistics.add(set_at(k, {0ns, drifting, k % 3 == 0 ? std::nullopt : std::optional<nanoseconds>(7us)}));
  }
  const auto summary = statistics.summary();
  EXPECT_EQ(summary.cameras[0].offset, 0ns);
  EXPECT_EQ(summary.cameras[2].offset, 7us);
  EXPECT_NEAR(summary.cameras[1].drift_ppm, 12.0, 0.05);
  EXPECT_NEAR(static_cast<double>(summary.cameras[1].jitter.count()), 2000.0, 100.0);
  EXPECT_NEAR(static_cast<double>(summary.cameras[1].offset.count()), 5e3 + 12e3 * 39.98, 200.0);
}

TEST(SyncStatistics, QuantilesOfTheSpreadAreThoseOfTheSets) {
  SyncStatistics statistics(2);
  for (std::uint64_t k = 1; k <= 1000; ++k) statistics.add(set_at(k, {0ns, nanoseconds(k * 1000)}));
  const auto summary = statistics.summary();
  EXPECT_EQ(summary.sets, 1000u);
  EXPECT_NEAR(static_cast<double>(summary.spread_median.count()), 500e3, 0.03 * 500e3);
  EXPECT_NEAR(static_cast<double>(summary.spread_p99.count()), 990e3, 0.03 * 990e3);
  EXPECT_EQ(summary.spread_max, 1ms);
}

TEST(SyncStatistics, SaysNothingOfNothing) {
  SyncStatistics statistics(2);
  EXPECT_EQ(statistics.summary().sets, 0u);
  statistics.add(set_at(0, {5ns, std::nullopt}));
  EXPECT_EQ(statistics.summary().sets, 0u) << "one frame has no spread";
  EXPECT_EQ(statistics.summary().cameras[1].offset, 0ns);
  EXPECT_THROW(statistics.add(set_at(0, {0ns})), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
