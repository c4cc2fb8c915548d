#include "simulator/people/board_act.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "simulator/people/act.h"

namespace rotunda::simulator {
namespace {

constexpr double kEnd = kBoardActFrames * kActStep;

TEST(BoardAct, StaysInsideTheVolumeAndAboveTheFloor) {
  const CarriedBoard board;
  for (double t = 0.0; t < kEnd; t += 0.02)
    for (const double u : {-0.5, 0.5})
      for (const double v : {-0.5, 0.5}) {
        const Eigen::Vector3d corner = board_pose(t) * Eigen::Vector3d(u * board.width, v * board.height, 0.0);
        EXPECT_LT(std::abs(corner.x()), 1.5) << t;
        EXPECT_LT(std::abs(corner.y()), 1.1) << t;
        EXPECT_GT(corner.z(), board.thickness - 1e-9) << t;
        EXPECT_LT(corner.z(), 2.0) << t;
      }
}

TEST(BoardAct, ItsFaceLooksToEverySideHighAndLow) {
  std::set<int> sectors;
  double low = 2.0, high = 0.0;
  for (double t = 0.0; t < 12.0; t += 0.04) {
    const auto pose = board_pose(t);
    const Eigen::Vector3d face = pose.linear().col(2);
    sectors.insert(static_cast<int>(std::floor(std::atan2(face.y(), face.x()) / (std::numbers::pi / 4.0))));
    low = std::min(low, pose.translation().z());
    high = std::max(high, pose.translation().z());
  }
  EXPECT_EQ(sectors.size(), 8U);
  EXPECT_LT(low, 0.8);
  EXPECT_GT(high, 1.5);
}

TEST(BoardAct, LiesFaceUpAtTheMiddleInTheEnd) {
  const auto pose = board_pose(kBoardLaidSeconds);
  EXPECT_LT((pose.translation() - Eigen::Vector3d(0.0, 0.0, CarriedBoard{}.thickness)).norm(), 1e-9);
  EXPECT_LT((pose.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_TRUE(board_pose(kEnd).isApprox(pose));
}

// A board in somebody's hands: no faster than a brisk walk, no jerk.
TEST(BoardAct, MovesSmoothly) {
  constexpr double kStep = 0.01;
  for (double t = kStep; t < kEnd - kStep; t += kStep) {
    const auto before = board_pose(t - kStep), now = board_pose(t), after = board_pose(t + kStep);
    EXPECT_LT((after.translation() - now.translation()).norm() / kStep, 1.4) << t;
    EXPECT_LT((after.translation() - 2.0 * now.translation() + before.translation()).norm(), 0.002) << t;
  }
}

}  // namespace
}  // namespace rotunda::simulator
