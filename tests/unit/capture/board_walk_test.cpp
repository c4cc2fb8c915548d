#include "capture/calibration/board_walk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/board_scene.h"

namespace rotunda::capture {
namespace {

using testing::HasSubstr;

std::vector<Sighting> at_moment(std::span<const CameraModel> rig, const Board& board, const Eigen::Isometry3d& pose) {
  return tests::sightings_of(rig, board, {&pose, 1});
}

TEST(BoardWalk, KeepsWhatIsNewAndEndsWhenEveryCameraHasEnough) {
  const Board board{};
  const auto rig = tests::board_rig(4, 720, 576, 1000.0);
  BoardWalk walk(rig, {board});
  const auto path = tests::board_walk(400, 5);
  EXPECT_TRUE(walk.add(at_moment(rig, board, path[0])));
  EXPECT_FALSE(walk.add(at_moment(rig, board, path[0])));  // nothing has changed
  EXPECT_FALSE(walk.add({}));
  auto blurred = at_moment(rig, board, path[1]);
  for (auto& sighting : blurred) sighting.blur_px = 2.8;
  EXPECT_FALSE(walk.add(blurred));
  EXPECT_FALSE(walk.is_enough());
  EXPECT_THAT(walk.needs()[0].needs, HasSubstr("more boards"));
  std::size_t shown = 0;
  while (shown < path.size() && !walk.is_enough()) walk.add(at_moment(rig, board, path[shown++]));
  EXPECT_TRUE(walk.is_enough());
  EXPECT_LT(walk.moments(), 150U);
  for (const auto& need : walk.needs()) EXPECT_GE(need.views, 15) << need.camera;
}

TEST(BoardWalk, SaysWhichCamerasMustSeeTheBoardTogether) {
  const Board board{};
  const auto rig = tests::board_rig(4);
  BoardWalk walk(rig, {board});
  std::size_t moment = 0;
  for (const auto& pose : tests::board_walk(60)) {
    auto found = at_moment(rig, board, pose);
    const bool third = moment++ % 2 == 0;
    std::erase_if(found, [&](const auto& sighting) { return (sighting.camera == 2) != third; });
    walk.add(std::move(found));
  }
  EXPECT_THAT(walk.needs()[2].needs, HasSubstr("together with cam00"));
  EXPECT_THAT(walk.needs()[0].needs, HasSubstr("together with cam02"));
}

}  // namespace
}  // namespace rotunda::capture
