#include "capture/source/exposure_counter.h"

#include <gtest/gtest.h>

namespace rotunda::capture {

TEST(ExposureCounter, GoesOnWhereSixteenBitsBeginAgain) {
  ExposureCounter counter;
  EXPECT_EQ(counter.count(65534), 65534u);
  EXPECT_EQ(counter.count(65535), 65535u);
  EXPECT_EQ(counter.count(1), 65536u) << "0 is no block's id";
  EXPECT_EQ(counter.count(3), 65538u);
  EXPECT_EQ(counter.count(2), 65537u);
  EXPECT_EQ(counter.count(0), std::nullopt);
}

TEST(ExposureCounter, AFrameOfTheRoundBeforeStaysThere) {
  ExposureCounter counter;
  for (std::uint64_t id : {65530u, 65535u, 2u}) counter.count(id);
  EXPECT_EQ(counter.count(65534), 65534u);
}

TEST(ExposureCounter, CountsManyRounds) {
  ExposureCounter counter;
  std::uint64_t expected = 0;
  for (int round = 0; round < 3; ++round)
    for (std::uint64_t id = 1; id <= 65535; ++id) ASSERT_EQ(counter.count(id), ++expected);
}

TEST(ExposureCounter, TakesWideIdsAsTheyAre) {
  ExposureCounter counter;
  for (std::uint64_t id = 65000; id < 70000; ++id) ASSERT_EQ(counter.count(id), id);
  EXPECT_EQ(counter.count(10'000'000'000), 10'000'000'000u);
}

}  // namespace rotunda::capture
