#include "capture/sync/trigger.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

Timestamp at(nanoseconds since_epoch) {
  return Timestamp(since_epoch);
}

TEST(TriggerGrid, StartsOnTheFirstMultipleOfThePeriod) {
  EXPECT_EQ(grid_from(at(81ms), 40ms).start, at(120ms));
  EXPECT_EQ(grid_from(at(120ms), 40ms).start, at(120ms));
  EXPECT_EQ(grid_from(at(120ms + 1ns), 40ms).start, at(160ms));
}

TEST(TriggerGrid, NearestIsTheRoundedQuotientOnBothSidesOfTheStart) {
  const TriggerGrid grid{at(1s), 40ms};
  EXPECT_EQ(grid.nearest(at(1s)), 0);
  EXPECT_EQ(grid.nearest(at(1s + 19999999ns)), 0);
  EXPECT_EQ(grid.nearest(at(1s + 20ms)), 1);
  EXPECT_EQ(grid.nearest(at(1s - 20ms)), 0);
  EXPECT_EQ(grid.nearest(at(1s - 20000001ns)), -1);
  for (std::uint64_t k : {0ull, 1ull, 99ull, 1000000000ull})
    EXPECT_EQ(grid.nearest(grid.time_of(k)), static_cast<std::int64_t>(k));
}

TEST(TriggerGrid, PeriodIsTheNearestNanosecondOfTheRate) {
  EXPECT_EQ(period_of(25), 40ms);
  EXPECT_EQ(period_of(30), 33333333ns);
  for (const double rate : {0.0, -1.0, 1e9, std::nan("")}) EXPECT_THROW(period_of(rate), InvalidInput) << rate;
}

int scheduling_of_this_thread() {
  int policy = SCHED_OTHER;
  sched_param priority{};
  pthread_getschedparam(pthread_self(), &policy, &priority);
  return policy;
}

bool may_be_timely() {
  bool may = false;
  std::thread([&] {
    const sched_param priority{.sched_priority = 1};
    may = pthread_setschedparam(pthread_self(), SCHED_RR, &priority) == 0;
  }).join();
  return may;
}

TEST(TriggerSchedule, GoesBeforeAllThatIsNotAsPressing) {
  int policy = -1;
  TriggerSchedule schedule(immediate_triggers(1000, 100, RigClock::now()),
                           [&](const Trigger&) { policy = scheduling_of_this_thread(); });
  schedule.wait();
  EXPECT_EQ(policy, may_be_timely() ? SCHED_RR : SCHED_OTHER) << "as far as this user may";
  EXPECT_EQ(scheduling_of_this_thread(), SCHED_OTHER) << "and no other thread";
}

TEST(TriggerSchedule, HandsOutExactlyTheCountOnTheGridAheadOfTime) {
  const Timestamp now = RigClock::now();
  const auto options = scheduled_triggers(100, 12, now);
  EXPECT_EQ(options.lead, 20ms);
  EXPECT_GE(options.grid.start, now + 30ms);
  EXPECT_EQ(options.grid.start.time_since_epoch() % options.grid.period, 0ns);
  std::vector<Trigger> fired;
  TriggerSchedule schedule(options, [&](const Trigger& trigger) { fired.push_back(trigger); });
  schedule.wait();
  const auto counts = schedule.counts();
  EXPECT_TRUE(counts.finished);
  EXPECT_EQ(counts.fired + counts.skipped, 12u);  // on a loaded machine some may have been too late
  EXPECT_EQ(fired.size(), counts.fired);
  for (const Trigger& trigger : fired) EXPECT_EQ(trigger.at, options.grid.time_of(trigger.number));
  for (std::size_t i = 1; i < fired.size(); ++i) EXPECT_LT(fired[i - 1].number, fired[i].number);
}

TEST(TriggerSchedule, NeverFiresASoftwareTriggerBeforeItsMoment) {
  const auto options = immediate_triggers(50, 5, RigClock::now());
  std::vector<nanoseconds> early;
  TriggerSchedule schedule(options, [&](const Trigger& trigger) {
    if (RigClock::now() < trigger.at) early.push_back(trigger.at - RigClock::now());
  });
  schedule.wait();
  EXPECT_TRUE(early.empty());
}

TEST(TriggerSchedule, SkipsAndCountsTriggersWhoseMomentHasPassed) {
  auto options = scheduled_triggers(100, 5, RigClock::now());
  options.grid.start -= 10s;
  TriggerSchedule schedule(options, [](const Trigger&) { FAIL() << "a trigger was sent onto another's place"; });
  schedule.wait();
  EXPECT_EQ(schedule.counts().skipped, 5u);
  EXPECT_EQ(schedule.counts().fired, 0u);
}

TEST(TriggerSchedule, StopsInTheMiddleOfAWait) {
  auto options = scheduled_triggers(1, std::nullopt, RigClock::now());
  options.grid.start += 1h;
  TriggerSchedule schedule(options, [](const Trigger&) { FAIL() << "an hour early"; });
  schedule.stop();
  EXPECT_TRUE(schedule.counts().finished);
  EXPECT_EQ(schedule.counts().fired, 0u);
}

TEST(TriggerSchedule, EndsWithWhatFiringThrewAndKeepsIt) {
  TriggerSchedule schedule(scheduled_triggers(100, 5, RigClock::now()),
                           [](const Trigger&) { throw std::runtime_error("the network is down"); });
  schedule.wait();
  EXPECT_TRUE(schedule.counts().finished);
  EXPECT_EQ(schedule.counts().fired, 0u);
  EXPECT_THROW(schedule.rethrow_failure(), std::runtime_error);
}

}  // namespace
}  // namespace rotunda::capture
