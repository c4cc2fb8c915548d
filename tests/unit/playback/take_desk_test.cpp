#include "playback/take_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rotunda::playback {
namespace {

using testing::Contains;
using testing::HasSubstr;

class ADeskOfATake : public testing::Test {
 protected:
  void press(Key key) { desk_.apply({.keys = {key}}, 0.0); }
  TakeDesk desk_{{.frames = 50, .first_frame = 10, .fps = 25.0, .has_pictures = true}, Orbit{}};
};

TEST_F(ADeskOfATake, PlaysRoundAndRoundAndSlowly) {
  desk_.go_on(1.0);
  EXPECT_NEAR(desk_.at(), 25.0, 1e-9);
  desk_.go_on(1.2);
  EXPECT_NEAR(desk_.at(), 5.0, 1e-9);
  press(Key::previous);  // a quarter as fast
  desk_.go_on(0.4);
  EXPECT_NEAR(desk_.at(), 7.5, 1e-9);
}

TEST_F(ADeskOfATake, FreezesAndStepsByWholeFramesOverTheEnds) {
  desk_.go_on(0.1);  // frame 2.5
  press(Key::space);
  desk_.go_on(5.0);
  EXPECT_NEAR(desk_.at(), 2.5, 1e-9);
  press(Key::next);
  EXPECT_EQ(desk_.at(), 3.0);
  for (int i = 0; i < 4; ++i) press(Key::previous);
  EXPECT_EQ(desk_.at(), 49.0);
  press(Key::next);
  EXPECT_EQ(desk_.at(), 0.0);
  EXPECT_THAT(desk_.lines("60 pictures/s"), Contains(AllOf(HasSubstr("frame 10"), HasSubstr("frozen"))));
}

TEST_F(ADeskOfATake, GoesToTenthsAndWindsWithTheStick) {
  desk_.apply({.digits = {5}}, 0.0);
  EXPECT_EQ(desk_.at(), 25.0);
  desk_.apply({.gamepad = Gamepad{.left_right = -1.0}}, 0.1);
  EXPECT_NEAR(desk_.at(), 15.0, 1e-9);  // four times as fast
  desk_.apply({.gamepad = Gamepad{.left_right = 0.1}}, 0.1);
  EXPECT_NEAR(desk_.at(), 15.0, 1e-9);
}

TEST_F(ADeskOfATake, WaitsForWhatIsNotThereYet) {
  desk_.go_on(0.4);
  desk_.go_on(0.2);
  desk_.wait();
  EXPECT_NEAR(desk_.at(), 10.0, 1e-9);
  desk_.apply({.digits = {9}}, 0.0);
  desk_.go_on(0.04);
  desk_.wait();
  EXPECT_NEAR(desk_.at(), 45.0, 1e-9);  // what was gone to is waited for
}

TEST_F(ADeskOfATake, FollowsThePerformerBesideWhomItLooksOrLetsGo) {
  desk_.look_at({1.0, 2.0, 1.0});
  EXPECT_EQ(desk_.orbit().target, Eigen::Vector3d(1.0, 2.0, 1.0));
  desk_.apply({.shift_x = 0.1}, 0.0);
  const Eigen::Vector3d beside = desk_.orbit().target - Eigen::Vector3d(1.0, 2.0, 1.0);
  EXPECT_GT(beside.norm(), 0.1);
  desk_.look_at({3.0, 2.0, 1.0});
  EXPECT_TRUE(desk_.orbit().target.isApprox(Eigen::Vector3d(3.0, 2.0, 1.0) + beside));
  press(Key::follow);
  const Eigen::Vector3d left = desk_.orbit().target;
  desk_.look_at({5.0, 2.0, 1.0});
  EXPECT_EQ(desk_.orbit().target, left);
  press(Key::home);
  EXPECT_EQ(desk_.orbit().target, Eigen::Vector3d(5.0, 2.0, 1.0));
}

TEST_F(ADeskOfATake, ShowsTheCamerasPicturesWhereThereAreAny) {
  EXPECT_TRUE(desk_.shows_pictures());
  press(Key::pictures);
  EXPECT_FALSE(desk_.shows_pictures());
  press(Key::help);
  EXPECT_THAT(desk_.lines("60 pictures/s"), Contains(HasSubstr("v  colours")));
  TakeDesk without({.frames = 50}, Orbit{});
  without.apply({.keys = {Key::pictures, Key::help}}, 0.0);
  EXPECT_FALSE(without.shows_pictures());
  EXPECT_THAT(without.lines("60 pictures/s"), Not(Contains(HasSubstr("v  colours"))));
}

TEST_F(ADeskOfATake, TurnsZoomsAndEnds) {
  const Orbit before = desk_.orbit();
  press(Key::left);
  press(Key::plus);
  EXPECT_LT(desk_.orbit().azimuth, before.azimuth);
  EXPECT_LT(desk_.orbit().distance, before.distance);
  desk_.apply({.drag_x = 0.1, .scroll = -3.0}, 0.0);
  EXPECT_GT(desk_.orbit().distance, before.distance);
  press(Key::quit);
  EXPECT_TRUE(desk_.ended());
}

}  // namespace
}  // namespace rotunda::playback
