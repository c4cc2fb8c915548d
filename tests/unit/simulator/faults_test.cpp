#include "simulator/gige/faults.h"

#include <gtest/gtest.h>

namespace rotunda::simulator {

TEST(GigeFaults, LoseTheShareAskedForAndTheSameAgain) {
  const GigeFaults faults{.seed = 5, .packet_loss = {.rate = 0.01}};
  int lost = 0, same = 0;
  constexpr int kPackets = 100'000;
  for (std::uint32_t packet = 0; packet < kPackets; ++packet) {
    const bool once = is_lost(faults, {3, 17, packet, 0});
    lost += once;
    same += once == is_lost(faults, {3, 17, packet, 0});
  }
  EXPECT_NEAR(lost, 1000, 160);  // five standard deviations of the binomial
  EXPECT_EQ(same, kPackets);
}

TEST(GigeFaults, AreDrawnAnewForEveryAttemptCameraAndSeed) {
  const GigeFaults faults{.packet_loss = {.rate = 0.5}};
  const GigeFaults other{.seed = 2, .packet_loss = {.rate = 0.5}};
  int attempt = 0, camera = 0, seed = 0;
  for (std::uint32_t packet = 0; packet < 1000; ++packet) {
    const bool lost = is_lost(faults, {0, 1, packet, 0});
    attempt += lost != is_lost(faults, {0, 1, packet, 1});
    camera += lost != is_lost(faults, {1, 1, packet, 0});
    seed += lost != is_lost(other, {0, 1, packet, 0});
  }
  for (const int changed : {attempt, camera, seed}) EXPECT_NEAR(changed, 500, 80);
}

}  // namespace rotunda::simulator
