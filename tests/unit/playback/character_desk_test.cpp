#include "playback/character_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "playback/graph_map.h"
#include "tests/support/walking_ball.h"

namespace rotunda::playback {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kFrame = 1.0 / 25.0;  // seconds

class Desk : public testing::Test {
 protected:
  void press(Key key) { desk_.apply({.keys = {key}}, player_, orbit_, kFrame); }
  void hold(const Gamepad& pad) { desk_.apply({.gamepad = pad}, player_, orbit_, kFrame); }
  void pass(int frames) {
    for (int i = 0; i < frames; ++i) desk_.go_on(player_, kFrame);
  }
  recon::MotionGraph graph_ = tests::ball_graph();
  CharacterPlayer player_{graph_, tests::ball_roots(graph_)};
  Orbit orbit_;
  CharacterDesk desk_{graph_, orbit_};
};

TEST_F(Desk, AsksForStatesAndActionsByNumber) {
  desk_.apply({.digits = {2, 9}}, player_, orbit_, kFrame);  // there is no ninth
  EXPECT_EQ(player_.wanted(), "roll");
  desk_.apply({.buttons = {Button::a}}, player_, orbit_, kFrame);
  EXPECT_EQ(player_.wanted(), "rest");
  desk_.apply({.digits = {3}}, player_, orbit_, kFrame);
  pass(60);
  EXPECT_EQ(player_.doing(), "rest");
  EXPECT_GE(player_.seams(), 2);  // out to the hop, and back
}

TEST_F(Desk, StepsBackThroughWhatWasSeenAndOn) {
  desk_.apply({.digits = {2}}, player_, orbit_, kFrame);
  pass(80);
  press(Key::space);
  const double now = desk_.go_on(player_, kFrame).place.x();
  EXPECT_EQ(desk_.go_on(player_, kFrame).place.x(), now);  // it is frozen
  press(Key::previous);
  press(Key::previous);
  EXPECT_NEAR(desk_.go_on(player_, kFrame).place.x(), now - 2.0 * tests::kBallSpeed * kFrame, 1e-9);
  EXPECT_THAT(desk_.lines(player_, "60 pictures/s"), Contains(HasSubstr("2 back")));
  for (int i = 0; i < 3; ++i) press(Key::next);
  EXPECT_NEAR(desk_.go_on(player_, kFrame).place.x(), now + tests::kBallSpeed * kFrame, 1e-9);
  for (int i = 0; i < 2000; ++i) press(Key::previous);
  EXPECT_NEAR(desk_.go_on(player_, kFrame).place.x(), 0.0, 0.05);  // no farther than the beginning
  press(Key::space);
  EXPECT_GT(desk_.go_on(player_, kFrame).place.x(), now);  // on from where it was left
}

TEST_F(Desk, PlaysSlowly) {
  desk_.apply({.digits = {2}}, player_, orbit_, kFrame);
  pass(80);
  const double before = desk_.go_on(player_, 0.0).place.x();
  press(Key::previous);
  EXPECT_NEAR(desk_.go_on(player_, kFrame).place.x() - before, 0.25 * tests::kBallSpeed * kFrame, 1e-9);
}

TEST_F(Desk, GoesWhereTheStickPointsSeenFromTheEye) {
  orbit_.azimuth = 0.0;  // the eye looks along -x: its right is +y
  hold({.left_right = 1.0});
  EXPECT_EQ(player_.wanted(), "roll");
  pass(150);
  EXPECT_NEAR(player_.appearance().heading, std::numbers::pi / 2.0, 1e-3);
  hold({.left_up = 1.0});  // away from the eye
  EXPECT_NEAR(std::abs(std::remainder(player_.aim(), 2.0 * std::numbers::pi)), std::numbers::pi, 1e-3);
  hold({.left_up = 0.05});  // let go: no stick rests quite in the middle
  EXPECT_EQ(player_.wanted(), "rest");
  const double azimuth = orbit_.azimuth, distance = orbit_.distance;
  hold({.right_right = 1.0, .closer = 1.0});
  EXPECT_NE(orbit_.azimuth, azimuth);
  EXPECT_LT(orbit_.distance, distance);
}

TEST_F(Desk, ShowsItsKeysWhenAsked) {
  EXPECT_EQ(desk_.lines(player_, "60 pictures/s").size(), 1U);
  press(Key::help);
  EXPECT_THAT(desk_.lines(player_, "60 pictures/s"), Contains("3  hop"));
  EXPECT_TRUE(desk_.shows_map());
  press(Key::map);
  EXPECT_FALSE(desk_.shows_map());
  press(Key::quit);
  EXPECT_TRUE(desk_.ended());
}

TEST(GraphMap, ShowsWhereTheCharacterIs) {
  const auto graph = tests::ball_graph();
  const auto rest = graph_map(graph, "rest", "rest"), roll = graph_map(graph, "roll", "roll"),
             between = graph_map(graph, "rest-roll", "roll");
  ASSERT_EQ(rest.type(), CV_8UC4);
  EXPECT_GT(cv::norm(rest, roll, cv::NORM_INF), 50.0);
  EXPECT_GT(cv::norm(between, roll, cv::NORM_INF), 50.0);
  EXPECT_EQ(cv::norm(rest, graph_map(graph, "rest", "rest"), cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace rotunda::playback
