#include "simulator/people/board_act.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "simulator/people/act.h"
#include "simulator/people/board_grip.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {
namespace {

constexpr double kEnd = kBoardActFrames * kActStep;

std::array<Eigen::Vector3d, 4> corners_at(double seconds) {
  const CarriedBoard board;
  const Eigen::Isometry3d pose = board_pose(seconds);
  const auto corner = [&](double u, double v) -> Eigen::Vector3d {
    return pose * Eigen::Vector3d(0.5 * u * board.width, 0.5 * v * board.height, 0.0);
  };
  return {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
}

std::vector<Skeleton> carriers() {
  std::vector<Skeleton> all;
  for (const auto& name : person_names()) {
    const auto build = describe_person(name).build;
    all.push_back(make_skeleton(build.height, build.proportions));
  }
  return all;
}

TEST(BoardAct, StaysInsideTheVolumeAndAboveTheFloor) {
  const CarriedBoard board;
  for (double t = 0.0; t < kEnd; t += 0.02)
    for (const auto& corner : corners_at(t)) {
      EXPECT_LT(std::abs(corner.x()), 1.5) << t;
      EXPECT_LT(std::abs(corner.y()), 1.1) << t;
      EXPECT_GT(corner.z(), board.thickness - 1e-9) << t;
      EXPECT_LT(corner.z(), 2.0) << t;
    }
}

TEST(BoardAct, ItsFaceLooksToEverySideHighAndLow) {
  std::set<int> sectors;
  double low = 2.0, high = 0.0;
  for (double t = 0.0; t < kBoardLaidSeconds - 1.5; t += 0.04) {
    const auto pose = board_pose(t);
    const Eigen::Vector3d face = pose.linear().col(2);
    sectors.insert((static_cast<int>(std::floor(std::atan2(face.y(), face.x()) / (std::numbers::pi / 4.0))) + 8) % 8);
    low = std::min(low, pose.translation().z());
    high = std::max(high, pose.translation().z());
  }
  EXPECT_EQ(sectors.size(), 8U);
  EXPECT_LT(low, 0.4);
  EXPECT_GT(high, 1.6);
}

// 3 m x 2 m x 2 m: under the ceiling as near as the arms of the shortest reach.
TEST(BoardAct, VisitsEveryCornerOfTheVolume) {
  for (const double x : {-1.5, 1.5})
    for (const double y : {-1.0, 1.0})
      for (const double z : {0.0, 2.0}) {
        double nearest = 10.0;
        for (double t = 0.0; t < kEnd; t += 0.04)
          for (const auto& corner : corners_at(t))
            nearest = std::min(nearest, (corner - Eigen::Vector3d(x, y, z)).norm());
        EXPECT_LT(nearest, 0.21) << x << ' ' << y << ' ' << z;
      }
}

TEST(BoardAct, HandsStayOnItsEdgesUntilItLies) {
  for (const auto& skeleton : carriers()) {
    const auto motion = motion_of("board", skeleton);
    for (double t = 0.0; t <= kBoardLaidSeconds; t += 0.04) {
      const auto board = board_pose(t);
      const auto joints = joint_transforms(skeleton, motion.pose_at(t));
      for (const Side side : {Side::left, Side::right}) {
        const Eigen::Vector3d palm = joints[index(on_side(Joint::hand_left, side))] *
                                     holding_point(skeleton, side, flatness_of_grip(skeleton, board));
        EXPECT_LT((palm - board * held_point({}, side)).norm(), 0.015) << skeleton.height << " m at " << t;
      }
    }
  }
}

// Limbs by their joints: the plate stays off them by about their radius.
TEST(BoardAct, NobodyStandsInTheBoardOrOnIt) {
  const CarriedBoard plate;
  for (const auto& skeleton : carriers()) {
    const auto motion = motion_of("board", skeleton);
    for (double t = 0.0; t <= kEnd; t += 0.04) {
      const auto centres = joint_centres(skeleton, motion.pose_at(t));
      for (const Joint joint : {Joint::head, Joint::chest, Joint::shank_left, Joint::shank_right, Joint::toes_left,
                                Joint::toes_right, Joint::forearm_left, Joint::forearm_right}) {
        const Eigen::Vector3d p = board_pose(t).inverse() * centres[index(joint)];
        const double outside = std::max({std::abs(p.x()) - 0.5 * plate.width, std::abs(p.y()) - 0.5 * plate.height,
                                         std::abs(p.z() + 0.5 * plate.thickness) - 0.5 * plate.thickness});
        const bool is_foot = joint == Joint::toes_left || joint == Joint::toes_right;  // by the ball
        EXPECT_GT(outside, is_foot ? 0.015 : 0.04) << to_string(joint) << " of " << skeleton.height << " m at " << t;
      }
    }
  }
}

TEST(BoardAct, HandsGoAwayFromTheBoardThatLies) {
  for (const auto& skeleton : carriers()) {
    const auto motion = motion_of("board", skeleton);
    for (double t = kBoardLaidSeconds - 1.0; t <= kEnd; t += 0.04) {
      const auto centres = joint_centres(skeleton, motion.pose_at(t));
      for (std::size_t j = index(Joint::hand_left); j <= index(Joint::little2_right); ++j)
        EXPECT_GT(centres[j].z(), 0.008) << to_string(static_cast<Joint>(j)) << " at " << t;  // a finger's radius
    }
    const auto end = joint_centres(skeleton, motion.pose_at(kEnd));
    for (const Joint hand : {Joint::hand_left, Joint::hand_right}) EXPECT_GT(end[index(hand)].z(), 0.7);
    for (const Joint toes : {Joint::toes_left, Joint::toes_right})  // it lies free
      EXPECT_LT(end[index(toes)].x(), -0.5 * CarriedBoard{}.height - 0.2);
  }
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
