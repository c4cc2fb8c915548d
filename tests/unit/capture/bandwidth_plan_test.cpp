#include "capture/sync/bandwidth_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

constexpr std::size_t kPalFrame = 720 * 576;
constexpr double kGigabit = 1e9;

std::vector<LinkLoad> cameras_on(const std::string& link, int count, int packet_size, std::size_t frame = kPalFrame) {
  std::vector<LinkLoad> loads;
  for (int i = 0; i < count; ++i) loads.push_back({"cam0" + std::to_string(i), link, frame, packet_size});
  return loads;
}

TEST(BandwidthPlan, CountsWhatEveryPacketCostsBesidePixels) {
  // 414720 bytes in 47 packets of 8864 pixels; 74 bytes more each, and leader and trailer.
  EXPECT_EQ(bits_on_the_wire(kPalFrame, 8900), 8 * (414720 + 47 * 74 + 2 * 74 + 46));
  EXPECT_GT(bits_on_the_wire(kPalFrame, 1400), 1.04 * bits_on_the_wire(kPalFrame, 8900));
}

TEST(BandwidthPlan, TenPalCamerasAt25HzFitOneGigabitLinkAndTakeTurns) {
  const auto loads = cameras_on("eth0", 10, 8900);
  const auto plan = plan_bandwidth(loads, {{"eth0", kGigabit}}, 25);
  ASSERT_EQ(plan.links.size(), 1U);
  EXPECT_TRUE(plan.links[0].fits);
  EXPECT_THAT(plan.links[0].arithmetic, AllOf(HasSubstr("eth0: 10 cameras x 418392 bytes"), HasSubstr("25 Hz"),
                                              HasSubstr("836.8 Mbit/s of the 900.0 usable (1000 Mbit/s")));
  // A packet takes 8938 bytes * 8 / 1 Gb/s = 71.504 us.
  EXPECT_EQ(plan.pacing[0], (StreamPacing{9 * 71504ns, 0ns}));
  EXPECT_EQ(plan.pacing[9], (StreamPacing{9 * 71504ns, 9 * 71504ns}));
  // All are done before the next frame.
  for (const auto& pacing : plan.pacing) EXPECT_LT(pacing.start_delay + 47 * (71504ns + pacing.packet_delay), 40ms);
}

TEST(BandwidthPlan, WhatDoesNotFitIsRefusedWithTheArithmeticAndARateThatWould) {
  const auto loads = cameras_on("eth0", 10, 1400);
  const auto plan = plan_bandwidth(loads, {{"eth0", kGigabit}}, 30);
  ASSERT_EQ(plan.links.size(), 1U);
  EXPECT_FALSE(plan.links[0].fits);
  EXPECT_THAT(plan.links[0].arithmetic,
              AllOf(HasSubstr("10 cameras"), HasSubstr("30 Hz"), HasSubstr("lower trigger.rate_hz to 25.")));
  const auto slower = plan_bandwidth(loads, {{"eth0", kGigabit}}, 25);
  EXPECT_TRUE(slower.links[0].fits);
}

TEST(BandwidthPlan, LinksAreCountedApartAndLoopbackIsUnlimited) {
  auto loads = cameras_on("eth0", 6, 8900);
  for (const auto& load : cameras_on("eth1", 6, 8900)) loads.push_back(load);
  loads.push_back({"local", "lo", 1U << 30, 8900});
  loads.push_back({"usb", "", kPalFrame, 0});
  const auto plan = plan_bandwidth(loads, {{"eth0", kGigabit}, {"eth1", kGigabit}}, 25);
  EXPECT_EQ(plan.links.size(), 2U);
  EXPECT_TRUE(plan.links[0].fits && plan.links[1].fits);
  EXPECT_EQ(plan.pacing[0].packet_delay, 5 * 71504ns);
  EXPECT_EQ(plan.pacing[6].start_delay, 0ns) << "the first of its link";
  EXPECT_EQ(plan.pacing[12], StreamPacing{});
  EXPECT_EQ(plan.pacing[13], StreamPacing{});
}

TEST(BandwidthPlan, ACameraAloneSendsAsItLikesAndOneWithManyPacketsTakesShorterPauses) {
  const auto alone = cameras_on("eth0", 1, 8900);
  EXPECT_EQ(plan_bandwidth(alone, {{"eth0", kGigabit}}, 25).pacing[0], StreamPacing{});
  auto uneven = cameras_on("eth0", 4, 8900, 100'000);
  uneven.push_back({"large", "eth0", 2'000'000, 8900});
  const auto plan = plan_bandwidth(uneven, {{"eth0", kGigabit}}, 25);
  EXPECT_TRUE(plan.links[0].fits);
  const auto packets = 226;  // 2000000 / 8864
  EXPECT_LE(packets * (71504ns + plan.pacing[4].packet_delay), 36001us) << "nine tenths of the period";
  EXPECT_LT(plan.pacing[4].packet_delay, plan.pacing[0].packet_delay);
}

TEST(BandwidthPlan, RefusesWhatMakesNoSense) {
  const auto loads = cameras_on("eth0", 1, 20);
  EXPECT_THROW(plan_bandwidth(loads, {{"eth0", kGigabit}}, 25), InvalidInput);
  EXPECT_THROW(plan_bandwidth(loads, {}, 0), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
