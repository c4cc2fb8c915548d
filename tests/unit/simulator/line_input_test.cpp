#include "simulator/gige/line_input.h"

#include <gtest/gtest.h>

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using namespace std::chrono_literals;

constexpr Timestamp kNow{1000s};

}  // namespace

TEST(LineInput, GivesEachEdgeOnceWhenItsTimeHasCome) {
  LineInput line;
  line.set(true, kNow + 10ms);
  line.set(true, kNow + 11ms);  // still high: no edge
  line.set(false, kNow + 12ms);
  EXPECT_FALSE(line.take_edge(kNow, 0ns));
  EXPECT_EQ(line.next_edge(0ns), kNow + 10ms);
  const auto rise = line.take_edge(kNow + 20ms, 0ns), fall = line.take_edge(kNow + 20ms, 0ns);
  ASSERT_TRUE(rise && fall);
  EXPECT_TRUE(rise->rising);
  EXPECT_EQ(fall->at, kNow + 12ms);
  EXPECT_FALSE(line.take_edge(kNow + 1h, 0ns));
  EXPECT_FALSE(line.is_high(kNow));
  EXPECT_TRUE(line.is_high(kNow + 11ms));
  EXPECT_FALSE(line.is_high(kNow + 12ms));
}

TEST(LineInput, TheDebouncerDropsBouncesAndDelaysWhatHolds) {
  LineInput line;
  line.set(true, kNow);
  line.set(false, kNow + 5us);  // a bounce
  line.set(true, kNow + 8us);
  line.set(false, kNow + 1ms);
  const auto rise = line.take_edge(kNow + 500us, 10us);
  ASSERT_TRUE(rise);
  EXPECT_EQ(rise->at, kNow + 18us);
  EXPECT_FALSE(line.take_edge(kNow + 1005us, 10us));
  EXPECT_EQ(line.next_edge(10us), kNow + 1010us);
  EXPECT_FALSE(line.take_edge(kNow + 1010us, 10us)->rising);
}

TEST(LineInput, AnActivationSelectsItsEdges) {
  const LineEdge rise{kNow, true}, fall{kNow, false};
  EXPECT_TRUE(rise.fires(TriggerActivation::rising_edge));
  EXPECT_FALSE(fall.fires(TriggerActivation::rising_edge));
  EXPECT_TRUE(fall.fires(TriggerActivation::falling_edge));
  EXPECT_FALSE(rise.fires(TriggerActivation::falling_edge));
  EXPECT_TRUE(rise.fires(TriggerActivation::any_edge) && fall.fires(TriggerActivation::any_edge));
}

}  // namespace rotunda::simulator
