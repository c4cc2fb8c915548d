// Cameras that were knocked, swapped or never saw a board together: named by whole calibrations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/calibration/calibrate.h"
#include "capture/calibration/camera_knock.h"
#include "tests/support/board_scene.h"
#include "tests/support/calibration_case.h"

namespace rotunda::capture {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using tests::kBoard;
using tests::named;
using tests::names_of;
using tests::options;
using tests::worst_baseline;

// The camera keeps every board it saw afterwards: none is judged by where it stood before.
TEST(CalibratedRig, NamesTheCameraThatWasKnockedAndKeepsItsLaterPose) {
  const auto rig = tests::board_rig(6);
  const auto walk = tests::board_walk(60);
  for (const double knock : {0.03, 0.08}) {  // metres: 5 and 13 px
    auto later = rig;
    later[2].t.x() += knock;
    auto sightings = tests::sightings_of(rig, kBoard, walk, 0.02);
    std::erase_if(sightings, [](const auto& sighting) { return sighting.camera == 2 && sighting.moment >= 30; });
    int afterwards = 0;
    for (const auto& sighting : tests::sightings_of(later, kBoard, walk, 0.02, 2))
      if (sighting.camera == 2 && sighting.moment >= 30) sightings.push_back(sighting), ++afterwards;
    const auto result = calibrate_sightings(rig, names_of(walk.size()), sightings, options());
    EXPECT_THAT(result.problems, ElementsAre(AllOf(HasSubstr("cam02 moved between m"), HasSubstr("px"))));
    EXPECT_EQ(result.verdict, Verdict::usable);
    EXPECT_EQ(result.quality[2].views, afterwards);
    EXPECT_LT(result.rms_px, 0.04);  // as without a knock
  }
}

// What is the smallest knock found follows from the noise: 0.8 px are sixteen noises, and nobody is named without one.
TEST(CalibratedRig, ASmallKnockIsToldOfTheRightCameraAndNoneOfNobody) {
  const auto rig = tests::board_rig(6);
  const auto walk = tests::board_walk(40, 6);
  for (const double knock_px : {0.0, 0.8}) {
    auto later = rig;
    later[3].t.x() += knock_px * 3.7 / 700.0;  // metres to the stage, pixels of focal length
    auto sightings = tests::sightings_of(rig, kBoard, walk, 0.05);
    std::erase_if(sightings, [](const auto& sighting) { return sighting.camera == 3 && sighting.moment >= 20; });
    for (const auto& sighting : tests::sightings_of(later, kBoard, walk, 0.05, 2))
      if (sighting.camera == 3 && sighting.moment >= 20) sightings.push_back(sighting);
    const auto result = calibrate_sightings(rig, names_of(walk.size()), sightings, options());
    if (knock_px > 0.0) {
      EXPECT_THAT(result.problems, ElementsAre(HasSubstr("cam03 moved between m")));
    } else {
      EXPECT_THAT(result.problems, IsEmpty());
    }
  }
}

// The true rig, and sightings of which those of cam03 from `first` on are `off` pixels to the right.
std::optional<Knock> knock_found(std::size_t first, double off) {
  constexpr double kNoise = 0.02;
  RigState state{.cameras = tests::board_rig(6)};
  auto walk = tests::board_walk(40, 6);
  for (int i = 0; i < 4; ++i) walk.push_back(walk.back());  // on the floor
  for (std::size_t i = 0; i < walk.size(); ++i) state.world_from_board[{i, 0}] = walk[i];
  auto sightings = tests::sightings_of(state.cameras, kBoard, walk, kNoise);
  for (auto& sighting : sightings)
    if (sighting.camera == 3 && sighting.moment >= first)
      for (auto& corner : sighting.corners) corner.pixel.x() += off;
  return find_knock(state, sightings, std::span(&kBoard, 1), kNoise);
}

// Five to ten boards a camera: its lens and its neighbours give way until no view looks odd.
TEST(CalibratedRig, AKnockIsToldWhereBoardsAreFew) {
  const auto rig = tests::board_rig(6);
  const auto walk = tests::board_walk(20);
  for (const std::size_t knocked : {0U, 1U, 5U})
    for (const double by : {0.0, 0.03}) {
      auto moved = rig;
      moved[knocked].t.x() += by;
      auto sightings = tests::sightings_of(rig, kBoard, walk, 0.05);
      for (auto& later : tests::sightings_of(moved, kBoard, walk, 0.05))
        if (later.camera == knocked && later.moment >= 10)
          for (auto& sighting : sightings)
            if (sighting.camera == knocked && sighting.moment == later.moment) sighting = later;
      const auto result = calibrate_sightings(rig, names_of(walk.size()), sightings, options());
      if (by > 0.0)
        EXPECT_THAT(result.problems, ElementsAre(HasSubstr(rig[knocked].name + " moved between m")));
      else
        EXPECT_THAT(result.problems, IsEmpty());
    }
}

// The same error in the same place tells of no knock however often it is seen, nor does what a board in motion is off.
TEST(CalibratedRig, AKnockTakesBoardsInDifferentPlacesAndMoreThanMotionDoes) {
  EXPECT_TRUE(knock_found(20, 0.8));
  EXPECT_FALSE(knock_found(20, 0.15));
  EXPECT_FALSE(knock_found(39, 0.8));
}

TEST(CalibratedRig, NamesCamerasThatNeverSeeABoardTogether) {
  const auto rig = tests::board_rig(4);
  const auto walk = tests::board_walk(24);
  auto sightings = tests::sightings_of(rig, kBoard, walk, 0.05);
  std::erase_if(sightings, [](const auto& s) { return (s.camera == 3) != (s.moment % 3 == 0); });
  const auto result = calibrate_sightings(rig, names_of(walk.size()), sightings, options());
  EXPECT_EQ(result.verdict, Verdict::rejected);
  EXPECT_EQ(result.cameras.size(), 3U);
  EXPECT_THAT(result.problems, Contains(HasSubstr("cam03 never saw the board at the same moment as cam00")));
}

TEST(CalibratedRig, NamesCamerasThatChangedPlaces) {
  const auto rig = tests::board_rig(5);
  const auto walk = tests::board_walk(20);
  auto swapped = tests::sightings_of(rig, kBoard, walk, 0.05);
  for (auto& sighting : swapped)
    if (sighting.camera == 1 || sighting.camera == 3) sighting.camera = 4 - sighting.camera;
  auto known = options();
  known.known = rig;
  const auto result = calibrate_sightings(rig, names_of(walk.size()), swapped, known);
  EXPECT_THAT(result.problems, ElementsAre(HasSubstr("cam01 and cam03 are swapped")));
}

TEST(CalibratedRig, NamesCamerasThatChangedPlacesMeanwhile) {
  for (const int cameras : {6, 10})
    for (const auto& [from, left_out] : {std::pair{14U, "before"}, {26U, "afterwards"}}) {
      const auto rig = tests::board_rig(cameras);
      const auto walk = tests::board_walk(40);
      auto swapped = tests::sightings_of(rig, kBoard, walk, 0.05);
      for (auto& sighting : swapped)
        if (sighting.camera < 2 && sighting.moment >= from) sighting.camera = 1 - sighting.camera;
      const auto result = calibrate_sightings(rig, names_of(walk.size()), swapped, options());
      ASSERT_THAT(result.problems, ElementsAre(HasSubstr("cam00 and cam01 were swapped by m"))) << cameras << from;
      EXPECT_THAT(result.problems[0], HasSubstr(std::string("showed ") + left_out + " is left out"));
      auto as_named = rig;
      if (from < 20) std::swap(as_named[0].name, as_named[1].name);  // most was seen under each other's names
      EXPECT_LT(worst_baseline(result.cameras, as_named), 0.02);
    }
}

}  // namespace
}  // namespace rotunda::capture
