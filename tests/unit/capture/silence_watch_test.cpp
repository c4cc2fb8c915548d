#include "capture/sync/silence_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/source/resend_budget.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr Timestamp kStart{1000s};
constexpr std::chrono::nanoseconds kPeriod = 40ms;

TEST(SilenceWatch, ACameraThatDiesAt25HzIsToldWithin180Milliseconds) {
  SilenceWatch watch(3, kPeriod);
  watch.begin(kStart);
  Timestamp died{};
  for (Timestamp now = kStart; now < kStart + 3s; now += kLookForSilence) {
    const bool frame = (now - kStart) % kPeriod == 0ms;
    for (const std::size_t camera : {0U, 1U, 2U}) {
      const bool dead = camera == 1 && now > kStart + 2s;
      if (frame && !dead) {
        EXPECT_FALSE(watch.heard(camera, now));
      }
    }
    const auto fallen = watch.look(now);
    if (fallen.empty()) continue;
    EXPECT_THAT(fallen, ElementsAre(1U)) << "told once, and no other";
    EXPECT_EQ(died, Timestamp{});
    died = now;
  }
  EXPECT_GT(died, kStart + 2s + 2 * kPeriod) << "one missed trigger is no silence";
  EXPECT_LE(died, kStart + 2s + 180ms);
  EXPECT_TRUE(watch.is_silent(1));
  EXPECT_EQ(watch.silent_for(1, kStart + 4s), 2s) << "since its last frame";
  EXPECT_EQ(watch.silent_for(0, kStart + 4s), 0s);
  EXPECT_TRUE(watch.heard(1, died + 1s)) << "it is back";
  EXPECT_FALSE(watch.is_silent(1));
  EXPECT_THAT(watch.look(died + 1s), ElementsAre(0U, 2U));
}

TEST(SilenceWatch, NothingIsExpectedBeforeTheFirstTriggerAndALittleMoreTimeAfterIt) {
  SilenceWatch watch(1, kPeriod);
  watch.begin(kStart + 10s);
  EXPECT_THAT(watch.look(kStart + 9s), IsEmpty());
  EXPECT_THAT(watch.look(kStart + 10s + 400ms), IsEmpty());
  EXPECT_THAT(watch.look(kStart + 10s + 500ms), ElementsAre(0U));
  EXPECT_THROW(SilenceWatch(1, 0ns), InvalidInput);
}

TEST(ResendBudget, StopsAskingWhileMoreThanItsShareIsAskedForAgain) {
  ResendBudget budget(0.25);
  EXPECT_TRUE(budget.look(10'000, 200));
  EXPECT_DOUBLE_EQ(budget.share(), 0.02);
  EXPECT_FALSE(budget.look(20'000, 3'200)) << "30 % since the last look";
  EXPECT_TRUE(budget.look(30'000, 3'200)) << "a pause is not for ever";
  EXPECT_TRUE(budget.look(30'100, 3'290)) << "a hundred packets are nothing to judge by";
  EXPECT_FALSE(budget.look(31'000, 3'500)) << "a thousand are";
  EXPECT_TRUE(budget.look(0, 0)) << "a stream that began anew";
}

}  // namespace
}  // namespace rotunda::capture
