#include "simulator/people/footfall.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace rotunda::simulator {
namespace {

constexpr double kPeriod = 1.0, kLift = 0.20;

// Stands for six tenths of the period, swings for the rest; strikes at `strike`.
double heel_at(double seconds, double strike) {
  const double phase = (seconds - strike) / kPeriod - std::floor((seconds - strike) / kPeriod);
  return phase < 0.6 ? 0.0 : kLift * std::sin(std::numbers::pi * (phase - 0.6) / 0.4);
}
std::array<double, 2> walking_heels(double seconds) {
  return {heel_at(seconds, 0.3), heel_at(seconds, 0.8)};
}

TEST(Footfall, FindsTheStrikesOfACycleAlsoThatWhichItBeginsWith) {
  const auto strikes = find_heel_strikes(walking_heels, {.duration = 2.0, .is_cyclic = true});
  ASSERT_EQ(strikes.size(), 4U);
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    EXPECT_NEAR(strikes[i].seconds, 0.3 + 0.5 * static_cast<double>(i), 0.02);
    EXPECT_EQ(strikes[i].side, i % 2 == 0 ? Side::left : Side::right);
  }
  const auto at_begin = find_heel_strikes(
      [](double s) {
        return std::array{heel_at(s, 0.02), 0.0};
      },
      {.duration = 1.0, .is_cyclic = true});
  ASSERT_EQ(at_begin.size(), 1U);
  EXPECT_NEAR(at_begin.front().seconds, 0.02, 0.02);
}

TEST(Footfall, OfAMotionThatEndsOnlyWhatIsSeen) {
  const auto strikes = find_heel_strikes(walking_heels, {.duration = 0.75, .is_cyclic = false});
  ASSERT_EQ(strikes.size(), 1U);  // the right foot is in the air when it ends
  EXPECT_EQ(strikes.front().side, Side::left);
}

TEST(Footfall, FeetThatAreDraggedOrNeverMoveStrikeNowhere) {
  const auto dragged = [](double s) { return std::array{0.1 * heel_at(s, 0.3), 0.0}; };
  EXPECT_TRUE(find_heel_strikes(dragged, {.duration = 4.0, .is_cyclic = true}).empty());
  EXPECT_TRUE(find_heel_strikes(walking_heels, {.duration = 0.0, .is_cyclic = true}).empty());
}

}  // namespace
}  // namespace rotunda::simulator
