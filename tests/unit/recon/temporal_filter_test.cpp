#include "recon/video/temporal_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace rotunda::recon {
namespace {

using Window = std::array<std::vector<Eigen::Vector3f>, kFilterFrames>;

TEST(TemporalFilter, WeightsOfTheMiddleAreTheTablesOfSavitzkyAndGolay) {
  const std::array<double, kFilterFrames> table{-2, 3, 6, 7, 6, 3, -2};  // over 21
  const auto weights = filter_weights(3);
  for (std::size_t i = 0; i < table.size(); ++i) EXPECT_NEAR(weights[i], table[i] / 21.0, 1e-12);
}

TEST(TemporalFilter, LeavesACubicMotionAsItIsAlsoAtTheEnds) {
  Window window;
  for (std::size_t i = 0; i < window.size(); ++i) {
    const auto t = static_cast<float>(i) / 25.0F;
    window[i] = {{2.0F * t, 5.0F * t * t, -40.0F * t * t * t}};  // up to half a metre a frame
  }
  for (int at = 0; at < kFilterFrames; ++at)
    EXPECT_LT((filtered(window, at, 1.0F)[0] - window[static_cast<std::size_t>(at)][0]).norm(), 1e-6F) << at;
}

TEST(TemporalFilter, TakesOutNoiseAndLeavesWhatSlides) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 0.001F);
  constexpr std::size_t kSamples = 4000;
  Window window;
  for (auto& frame : window)
    for (std::size_t v = 0; v < kSamples; ++v) frame.emplace_back(noise(random), noise(random), noise(random));
  const auto free = filtered(window, 3, 1.0F);
  double before = 0.0, after = 0.0;
  for (std::size_t v = 0; v < kSamples; ++v) {
    before += window[3][v].squaredNorm();
    after += free[v].squaredNorm();
  }
  for (auto& position : window[3]) position.x() += 0.02F;  // as no motion does
  EXPECT_EQ(filtered(window, 3, 0.004F), window[3]);
  EXPECT_NEAR(std::sqrt(after / before), std::sqrt(7.0 / 21.0), 0.02);  // the middle's own weight is the variance left
}

}  // namespace
}  // namespace rotunda::recon
