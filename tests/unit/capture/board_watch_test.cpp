#include "capture/calibration/board_watch.h"

#include <gtest/gtest.h>

#include "tests/support/board_scene.h"

namespace rotunda::capture {
namespace {

constexpr double kNoise = 0.1;  // pixels, a corner and axis

// The first so many cameras of a ring of nine: 40 degrees apart.
std::vector<CameraModel> arc(std::size_t count) {
  auto rig = tests::board_rig(9);
  rig.resize(count);
  return rig;
}

// So many pixels sideways or down in its picture, all over it.
void knock(CameraModel& camera, double right_px, double down_px) {
  const Eigen::Vector3d axis = Eigen::Vector3d(down_px, -right_px, 0.0) / -camera.K(0, 0);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
  camera.R = Eigen::Matrix3d(turn * camera.R);
  camera.t = Eigen::Vector3d(turn * camera.t);
}

std::vector<BoardShift> shifts_of(const std::vector<CameraModel>& calibrated, const std::vector<CameraModel>& now) {
  const Board board{};
  return board_shifts(calibrated, tests::sightings_of(now, board, tests::board_walk(15), kNoise), std::vector{board});
}

std::vector<std::size_t> moved_of(const std::vector<BoardShift>& shifts) {
  std::vector<std::size_t> moved;
  for (std::size_t i = 0; i < shifts.size(); ++i)
    if (shifts[i].moved) moved.push_back(i);
  return moved;
}

TEST(BoardWatch, TellsWhichCameraMovedAndByHowMuch) {
  const auto rig = tests::board_rig(4);
  auto now = rig;
  now[1].t.y() += 0.01;  // 2 px at 3.6 m
  const auto shifts = shifts_of(rig, now);
  ASSERT_EQ(shifts.size(), 4U);
  EXPECT_EQ(moved_of(shifts), (std::vector<std::size_t>{1}));
  EXPECT_NEAR(shifts[1].shift_px, 2.0, 0.8);
}

TEST(BoardWatch, NobodyIsToldWhereAllStandStill) {
  for (const std::size_t count : {2U, 3U, 5U, 9U}) {
    const auto rig = arc(count);
    EXPECT_TRUE(moved_of(shifts_of(rig, rig)).empty()) << count << " cameras";
  }
}

TEST(BoardWatch, OfThreeCamerasOnlyTheKnockedOneIsTold) {
  const auto rig = arc(3);
  for (std::size_t knocked = 0; knocked < rig.size(); ++knocked)
    for (const auto& [right, down] : {std::pair{5.0, 0.0}, {0.0, 5.0}, {-3.0, 3.0}}) {
      auto now = rig;
      knock(now[knocked], right, down);
      const auto shifts = shifts_of(rig, now);
      EXPECT_EQ(moved_of(shifts), (std::vector<std::size_t>{knocked})) << right << ", " << down;
      EXPECT_NEAR(shifts[knocked].shift_px, std::hypot(right, down), 0.25 * std::hypot(right, down));
    }
}

TEST(BoardWatch, SeveralKnockedCamerasAreToldAndNoOther) {
  const auto rig = arc(7);
  auto now = rig;
  knock(now[2], 6.0, 0.0), knock(now[3], 0.0, -4.0), knock(now[5], 12.0, 9.0);
  EXPECT_EQ(moved_of(shifts_of(rig, now)), (std::vector<std::size_t>{2, 3, 5}));
}

TEST(BoardWatch, OfTwoThatDisagreeItIsNotSaidWhichMoved) {
  const auto rig = arc(2);
  auto now = rig;
  knock(now[1], 0.0, 5.0);
  const auto shifts = shifts_of(rig, now);
  EXPECT_EQ(moved_of(shifts).size(), 2U);
  EXPECT_TRUE(shifts[0].disputed && shifts[1].disputed);
}

TEST(BoardWatch, ACameraAloneWithItsBoardIsNotTold) {
  const Board board{};
  const auto rig = arc(3);
  auto sightings = tests::sightings_of(rig, board, tests::board_walk(24), kNoise);
  for (auto& sighting : sightings)
    if (sighting.camera == 2) sighting.moment += 100;
  const auto shifts = board_shifts(rig, sightings, std::vector{board});
  EXPECT_EQ(shifts[2].corners, 0);
  EXPECT_FALSE(shifts[2].moved);
  EXPECT_GT(shifts[0].corners, 0);
}

}  // namespace
}  // namespace rotunda::capture
