#include "simulator/studio/sample_raster.h"

#include <gtest/gtest.h>

#include <random>

namespace rotunda::simulator {
namespace {

int count(const SampleRaster& raster, int columns, int rows, std::uint32_t number) {
  int found = 0;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) found += raster.at(x, y) == number ? 1 : 0;
  return found;
}

TEST(SampleRaster, CoversTheSamplesWhoseCentresLieInside) {
  SampleRaster raster(40, 30);
  raster.add({{{2.0F, 2.0F, 1.0F}, {12.0F, 2.0F, 1.0F}, {2.0F, 12.0F, 1.0F}}}, 7);
  EXPECT_NEAR(count(raster, 40, 30, 7), 50, 5);  // half the samples on the slanted edge, whose centres it cuts
  EXPECT_EQ(raster.at(2, 2), 7U);
  EXPECT_EQ(raster.at(1, 5), 0U);
  EXPECT_EQ(raster.touched(5)[0], 2);
  raster.clear();
  EXPECT_EQ(count(raster, 40, 30, 0), 40 * 30);
}

// A fan of slivers about any point leaves no hole, in either orientation and beyond the rim.
TEST(SampleRaster, NeighboursLeaveNoHoles) {
  constexpr int kSide = 64;
  std::mt19937 random(3);
  SampleRaster raster(kSide, kSide);
  for (int trial = 0; trial < 50; ++trial) {
    const auto unit = [&] { return static_cast<float>(random() % 65536) / 65536.0F; };
    const SampleCorner middle{kSide * unit(), kSide * unit(), 0.5F};
    std::vector<SampleCorner> rim;
    for (int side = 0; side < 4; ++side)
      for (int i = 0; i < 9; ++i) {
        const float t = -10.0F + 84.0F * static_cast<float>(i) / 9.0F;
        const std::array<SampleCorner, 4> at{
            {{t, -10.0F, 1.0F}, {74.0F, t, 1.0F}, {64.0F - t, 74.0F, 1.0F}, {-10.0F, 64.0F - t, 1.0F}}};
        rim.push_back(at[static_cast<std::size_t>(side)]);
      }
    for (std::size_t i = 0; i < rim.size(); ++i)
      raster.add({{middle, rim[i], rim[(i + 1) % rim.size()]}}, static_cast<std::uint32_t>(i + 1));
    EXPECT_EQ(count(raster, kSide, kSide, 0), 0) << trial;
    raster.clear();
  }
}

TEST(SampleRaster, TheNearerTriangleIsSeenWhateverTheOrder) {
  for (const bool near_first : {true, false}) {
    SampleRaster raster(20, 20);
    const SampleTriangle near{{{0.0F, 0.0F, 0.5F}, {20.0F, 0.0F, 0.5F}, {0.0F, 20.0F, 0.5F}}};
    const SampleTriangle far{{{0.0F, 0.0F, 0.2F}, {0.0F, 20.0F, 0.2F}, {20.0F, 20.0F, 0.2F}}};
    raster.add(near_first ? near : far, near_first ? 1 : 2);
    raster.add(near_first ? far : near, near_first ? 2 : 1);
    EXPECT_EQ(raster.at(2, 10), 1U);   // both
    EXPECT_EQ(raster.at(12, 18), 2U);  // only the far one
  }
}

// A square that recedes: half way across the picture is not half way along the square.
TEST(SampleRaster, WeightsAreTrueInSpace) {
  const SampleTriangle receding{{{0.0F, 0.0F, 1.0F}, {10.0F, 0.0F, 0.25F}, {0.0F, 10.0F, 1.0F}}};
  EXPECT_NEAR(weights_at(receding, 5.0F, 0.0F)[1], 0.2F, 1e-5F);  // 0.25 / (1 + 0.25)
  EXPECT_NEAR(weights_at(receding, 3.0F, 4.0F).sum(), 1.0F, 1e-5F);
}

}  // namespace
}  // namespace rotunda::simulator
