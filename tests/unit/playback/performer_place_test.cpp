#include "playback/performer_place.h"

#include <gtest/gtest.h>

#include <vector>

namespace rotunda::playback {
namespace {

// A root that walks at 40 mm a frame and bobs.
std::vector<Eigen::Vector3d> walk(int frames) {
  std::vector<Eigen::Vector3d> root;
  for (int i = 0; i < frames; ++i) root.emplace_back(0.04 * i, 0.0, i % 2 == 0 ? 0.98 : 1.02);
  return root;
}

TEST(PerformerPlace, GoesAlongWithTheRootAtOneHeight) {
  const auto root = walk(50);
  const PerformerPath path{.root = root, .box = {Eigen::Vector3d(-0.5, -0.5, -1.0), Eigen::Vector3d(0.5, 0.5, 0.8)}};
  const auto place = performer_place(path, {0, 50}, 20);
  EXPECT_NEAR(place.x(), 0.8, 1e-9);
  EXPECT_NEAR(place.z(), 1.0 - 0.1, 1e-9);
  EXPECT_NEAR(performer_place(path, {0, 50}, 21).z(), place.z(), 1e-9);
}

TEST(PerformerPlace, LiesBetweenFramesWhatIsDrawnBetweenThem) {
  const auto root = walk(50);
  const PerformerPath boxed{.root = root, .box = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}};
  EXPECT_NEAR(performer_place(boxed, {0, 50}, 20.25).x(), 0.81, 1e-9);
  EXPECT_EQ(performer_place(boxed, {0, 50}, 49.7), performer_place(boxed, {0, 50}, 49.0));  // there is no next
}

}  // namespace
}  // namespace rotunda::playback
