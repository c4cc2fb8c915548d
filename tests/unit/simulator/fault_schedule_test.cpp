#include "simulator/gige/fault_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using testing::ElementsAre;
using namespace std::chrono_literals;

constexpr Timestamp kStart{1'000'000s};

}  // namespace

TEST(FaultSchedule, HoldsAFaultFromItsBeginUpToItsEnd) {
  FaultSchedule schedule;
  schedule.add({.effect = Silence{}, .after = 2s, .lasts = 3s}, kStart);
  EXPECT_FALSE(schedule.in_force(kStart + 2s - 1ns).silent);
  EXPECT_TRUE(schedule.in_force(kStart + 2s).silent);
  EXPECT_TRUE(schedule.in_force(kStart + 5s - 1ns).silent);
  EXPECT_FALSE(schedule.in_force(kStart + 5s).silent);
  EXPECT_TRUE(schedule.kinds_in_force(kStart).empty());
  EXPECT_THAT(schedule.kinds_in_force(kStart + 3s), ElementsAre(FaultKind::silence));
}

TEST(FaultSchedule, StaysForGoodWithoutAnEndUntilCleared) {
  FaultSchedule schedule;
  schedule.set_seed(9);
  schedule.add({.effect = PacketLoss{.rate = 0.2}}, kStart);
  const auto faults = schedule.in_force(kStart + 100h);
  EXPECT_EQ(faults.packet_loss.rate, 0.2);
  EXPECT_EQ(faults.seed, 9U);
  schedule.clear();
  EXPECT_EQ(schedule.in_force(kStart + 100h).packet_loss.rate, 0.0);
}

TEST(FaultSchedule, StrikesExactlyTheTriggersAskedFor) {
  FaultSchedule schedule;
  schedule.add({.effect = Stall{}, .at_trigger = 4, .triggers = 2}, kStart);
  std::vector<int> struck;
  for (int k = 1; k <= 8; ++k) {
    const Timestamp at = kStart + k * 40ms;
    EXPECT_EQ(schedule.note_trigger(at), static_cast<std::uint64_t>(k));
    if (schedule.in_force(at).stalled) struck.push_back(k);
  }
  EXPECT_THAT(struck, ElementsAre(4, 5));
}

TEST(FaultSchedule, TriggersHeardAheadOfTheirTimeChangeNothingOfWhatIsNow) {
  FaultSchedule schedule;
  schedule.add({.effect = Silence{}, .at_trigger = 1, .after = 5ms, .lasts = 10ms}, kStart);
  schedule.note_trigger(kStart + 80ms);
  EXPECT_FALSE(schedule.in_force(kStart).silent);
  EXPECT_FALSE(schedule.in_force(kStart + 84ms).silent);
  EXPECT_TRUE(schedule.in_force(kStart + 85ms).silent);
  EXPECT_FALSE(schedule.in_force(kStart + 95ms).silent);
}

TEST(FaultSchedule, CountsTriggersFromTheFaultsOwnBegin) {
  FaultSchedule schedule;
  schedule.note_trigger(kStart);
  schedule.add({.effect = MissedTrigger{.every = 1}, .triggers = 2}, kStart + 10ms);
  std::vector<bool> missed;
  for (int k = 1; k <= 4; ++k) {
    schedule.note_trigger(kStart + k * 40ms);
    missed.push_back(schedule.in_force(kStart + k * 40ms).missed_trigger.every == 1);
  }
  EXPECT_THAT(missed, ElementsAre(true, true, false, false));
}

TEST(FaultSchedule, TheLastAddedOfOneKindHolds) {
  FaultSchedule schedule;
  schedule.set_standing({.packet_loss = {.rate = 0.1}});
  schedule.add({.effect = PacketLoss{.rate = 0.2}, .lasts = 2s}, kStart);
  schedule.add({.effect = PacketLoss{.rate = 0.3}, .lasts = 1s}, kStart);
  EXPECT_EQ(schedule.in_force(kStart).packet_loss.rate, 0.3);
  EXPECT_EQ(schedule.in_force(kStart + 1s).packet_loss.rate, 0.2);
  EXPECT_EQ(schedule.in_force(kStart + 2s).packet_loss.rate, 0.1);
}

TEST(FaultSchedule, AClockKeepsWhatItGainedAndStepsBack) {
  FaultSchedule schedule;
  schedule.add({.effect = ClockDrift{.ppm = 50.0}, .lasts = 10s}, kStart);
  schedule.add({.effect = ClockStep{.by = -3ms}, .after = 20s, .lasts = 1s}, kStart);
  EXPECT_EQ(schedule.clock_error(kStart), 0ns);
  EXPECT_EQ(schedule.clock_error(kStart + 2s), 100us);
  EXPECT_EQ(schedule.clock_error(kStart + 15s), 500us);
  EXPECT_EQ(schedule.clock_error(kStart + 20s), 500us - 3ms);
  EXPECT_EQ(schedule.clock_error(kStart + 21s), 500us);
  schedule.take_edges(kStart + 30s);
  schedule.add({.effect = Stall{}}, kStart + 30s);  // forgets what is over, not what it left
  EXPECT_EQ(schedule.clock_error(kStart + 30s), 500us);
}

TEST(FaultSchedule, TellsEveryBeginAndEndOnceAndInOrder) {
  FaultSchedule schedule;
  schedule.add({.effect = Reboot{}, .after = 3s, .lasts = 2s}, kStart);
  schedule.add({.effect = Silence{}, .after = 1s, .lasts = 3s}, kStart);
  EXPECT_TRUE(schedule.take_edges(kStart + 999ms).empty());
  const auto edges = schedule.take_edges(kStart + 4s);
  ASSERT_EQ(edges.size(), 3U);
  EXPECT_EQ(edges[0].kind, FaultKind::silence);
  EXPECT_EQ(edges[1].kind, FaultKind::reboot);
  EXPECT_EQ(edges[2].kind, FaultKind::silence);
  EXPECT_FALSE(edges[2].begins);
  EXPECT_EQ(edges[2].at, kStart + 4s);
  EXPECT_TRUE(schedule.take_edges(kStart + 4s).empty());
  EXPECT_EQ(schedule.take_edges(kStart + 1h).size(), 1U);
}

TEST(FaultSchedule, TemperatureRisesEvenly) {
  FaultSchedule schedule;
  schedule.add({.effect = OverTemperature{.celsius = 90.0, .within = 10s}}, kStart);
  EXPECT_DOUBLE_EQ(schedule.in_force(kStart + 5s).heat->progress, 0.5);
  EXPECT_DOUBLE_EQ(schedule.in_force(kStart + 20s).heat->progress, 1.0);
}

TEST(FaultSchedule, RefusesMoreThanItKeepsAndForgetsWhatIsOver) {
  FaultSchedule schedule;
  for (std::size_t i = 0; i < FaultSchedule::kMaxFaults; ++i)
    ASSERT_TRUE(schedule.add({.effect = Stall{}, .lasts = 1s}, kStart));
  EXPECT_FALSE(schedule.add({.effect = Stall{}}, kStart));
  schedule.take_edges(kStart + 2s);
  EXPECT_TRUE(schedule.add({.effect = Stall{}}, kStart + 2s));
}

}  // namespace rotunda::simulator
