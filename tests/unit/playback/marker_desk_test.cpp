#include "playback/marker_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "playback/display/click_finder.h"
#include "playback/surface_pick.h"
#include "tests/support/template_person.h"

namespace rotunda::playback {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// The scan is the template itself, so that both halves of the window show the same.
class ADeskOfMarkers : public testing::Test {
 protected:
  ADeskOfMarkers() {
    const auto one = tests::someone();
    scan_.mesh = tests::scan_of(one);
    for (std::uint32_t t = 0; t < scan_.mesh.triangles.size(); ++t) scan_.from_triangle.push_back(t);
    const std::uint32_t belly = at_front({0.0, 0.0, one.pose.root.z()});
    editor_.emplace(scan_, recon::Markers{.pairs = {{5, belly, belly}}, .fit = recon::TemplateFit{one.body, one.pose}});
    desk_.emplace(*editor_, TakeTold{.frames = 100, .fps = 50.0}, orbit());
  }
  static Orbit orbit() { return {.target = {0.0, 0.0, 0.9}, .distance = 4.0, .elevation = 0.0}; }

  // The triangle that the eye sees in front of a place.
  std::uint32_t at_front(const Eigen::Vector3d& place) const {
    const auto eye = kLayout.viewpoint(MarkerSide::body, orbit());
    return pick(scan_.mesh, eye, seen_at(eye, place)->head<2>()).value().triangle;
  }
  MousePlace on(MarkerSide side, const Eigen::Vector3d& place) const {
    const auto seen = seen_at(kLayout.viewpoint(side, desk_->orbit()), place);
    return {seen->x() + kLayout.left(side), seen->y()};
  }
  MousePlace on(MarkerSide side, std::uint32_t triangle) const {
    return on(side, recon::middle_of(scan_.mesh, triangle).cast<double>());
  }
  MarkerScene scene() const { return {scan_.mesh, scan_.mesh, kLayout}; }
  void press(Key key) { desk_->apply({.keys = {key}}, scene(), 0.0); }
  void click(const MousePlace& place) { desk_->apply({.clicks = {{place}}}, scene(), 0.0); }
  const std::vector<recon::Marker>& pairs() const { return editor_->markers().pairs; }

  // An odd width: the halves are not alike.
  static constexpr MarkerLayout kLayout{901, 480};
  recon::PreparedScan scan_;
  std::optional<recon::MarkerEditor> editor_;
  std::optional<MarkerDesk> desk_;
};

constexpr MarkerSide kBody = MarkerSide::body, kScan = MarkerSide::scan;
const Eigen::Vector3d kThigh(0.0, 0.12, 0.65);  // of the left leg

TEST_F(ADeskOfMarkers, MakesAPairOfTwoClicksInEitherOrder) {
  const auto thigh = at_front(kThigh);
  click(on(kBody, thigh));
  EXPECT_EQ(desk_->pending().body, thigh);
  EXPECT_THAT(desk_->lines(""), Contains("now its place on the scan"));
  click(on(kScan, thigh));
  ASSERT_EQ(pairs().size(), 3U);  // with its mirror
  EXPECT_EQ(pairs()[1], (recon::Marker{6, thigh, thigh}));
  EXPECT_FALSE(desk_->pending().body || desk_->pending().scan);
  press(Key::undo);
  click(on(kScan, thigh));
  click(on(kBody, thigh));
  EXPECT_EQ(pairs()[1], (recon::Marker{6, thigh, thigh}));
}

TEST_F(ADeskOfMarkers, SelectsADotAndMovesEitherEndOfItsPair) {
  const auto belly = pairs()[0].scan_triangle;
  auto near = on(kScan, belly);
  near.x += 6.0;
  click(near);
  ASSERT_NE(editor_->selected(), nullptr);
  EXPECT_EQ(editor_->selected()->number, 5);
  EXPECT_THAT(desk_->lines(""), Contains(HasSubstr("selected: 5 on pelvis")));
  const auto other = at_front({0.0, 0.06, 0.93});
  click(on(kScan, other));
  EXPECT_EQ(pairs()[0], (recon::Marker{5, belly, other}));
  click(on(kBody, other));
  EXPECT_EQ(pairs()[0], (recon::Marker{5, other, other}));
  press(Key::add);
  EXPECT_EQ(editor_->selected(), nullptr);
}

TEST_F(ADeskOfMarkers, TakesKeysAndClicksOfOneMomentInTheirOrder) {
  const auto belly = pairs()[0].scan_triangle, other = at_front({0.0, 0.06, 0.93});
  press(Key::next_item);
  desk_->apply({.keys = {Key::add}, .clicks = {{on(kScan, other), 1}}}, scene(), 0.0);
  EXPECT_EQ(pairs()[0].scan_triangle, belly);
  EXPECT_EQ(desk_->pending().scan, other);
  press(Key::next_item);
  desk_->apply({.keys = {Key::add}, .clicks = {{on(kScan, other), 0}}}, scene(), 0.0);
  EXPECT_EQ(pairs()[0].scan_triangle, other);
}

TEST_F(ADeskOfMarkers, ABesideClickSelectsNoneAndDropsHalfAPair) {
  click(on(kBody, pairs()[0].template_triangle));
  ASSERT_TRUE(editor_->selected());
  click({3.0, 200.0});
  EXPECT_FALSE(editor_->selected());
  click(on(kBody, at_front(kThigh)));
  ASSERT_TRUE(desk_->pending().body);
  click({kLayout.width - 3.0, 200.0});
  EXPECT_FALSE(desk_->pending().body);
  EXPECT_EQ(pairs().size(), 1U);
}

TEST_F(ADeskOfMarkers, DoesNotSelectDotsBehindTheBody) {
  const auto belly = on(kScan, pairs()[0].scan_triangle);
  for (int i = 0; i < 40; ++i) press(Key::left);  // 40 times .08: about to the back
  const auto behind = on(kScan, pairs()[0].scan_triangle);
  EXPECT_NEAR(behind.x, belly.x, 30.0);
  click(behind);
  EXPECT_EQ(editor_->selected(), nullptr);
  EXPECT_TRUE(desk_->pending().scan);  // the back was clicked
}

TEST_F(ADeskOfMarkers, TellsARefusalAndLeavesThePairs) {
  press(Key::next_item);
  click(on(kBody, at_front({0.0, 0.13, 0.35})));  // a shank, for the belly's place
  EXPECT_THAT(desk_->lines(""), Contains(HasSubstr("left for right, or another scan's markers?")));
  EXPECT_EQ(pairs()[0].template_triangle, pairs()[0].scan_triangle);
  press(Key::remove);
  EXPECT_THAT(desk_->lines(""), Contains(HasSubstr("must stay")));
}

TEST_F(ADeskOfMarkers, UndoesRedoesAndSwitchesSides) {
  press(Key::both_sides);
  EXPECT_THAT(desk_->lines(""), Contains(HasSubstr("one side")));
  const auto thigh = at_front(kThigh);
  click(on(kBody, thigh));
  click(on(kScan, thigh));
  EXPECT_EQ(pairs().size(), 2U);
  EXPECT_THAT(desk_->lines(""), Contains(HasSubstr("not saved")));
  press(Key::undo);
  EXPECT_EQ(pairs().size(), 1U);
  EXPECT_THAT(desk_->lines(""), Not(Contains(HasSubstr("not saved"))));
  press(Key::redo);
  EXPECT_EQ(pairs().size(), 2U);
  press(Key::previous_item);
  press(Key::remove);
  EXPECT_EQ(pairs().size(), 1U);
  EXPECT_FALSE(desk_->take_save());
  press(Key::save);
  EXPECT_TRUE(desk_->take_save());
  EXPECT_FALSE(desk_->take_save());
}

TEST_F(ADeskOfMarkers, BeginsAsScannedAndScrubsAlongTheBar) {
  EXPECT_FALSE(desk_->frame());
  EXPECT_FALSE(desk_->moves());
  EXPECT_THAT(desk_->lines(""), Contains(HasSubstr("as scanned")));
  const double middle = kLayout.height - 0.5 * MarkerLayout::kBar;
  const auto azimuth = desk_->orbit().azimuth;
  desk_->apply({.drag_x = 0.3, .dragged = MouseDrag{{10.0, middle}, {450.0, 20.0}}}, scene(), 0.0);
  EXPECT_EQ(desk_->frame(), 50);
  EXPECT_EQ(desk_->orbit().azimuth, azimuth);  // the bar is dragged, not the eye
  desk_->apply({.dragged = MouseDrag{{10.0, middle}, {5000.0, middle}}}, scene(), 0.0);
  EXPECT_EQ(desk_->frame(), 99);
  click({0.0, middle});
  EXPECT_EQ(desk_->frame(), 0);
  press(Key::next);
  EXPECT_EQ(desk_->frame(), 1);
  press(Key::rest);
  EXPECT_FALSE(desk_->frame());
  press(Key::space);  // plays on from there
  EXPECT_TRUE(desk_->moves());
  desk_->go_on(0.1);
  EXPECT_EQ(desk_->frame(), 6);
  press(Key::space);
  EXPECT_FALSE(desk_->moves());
  press(Key::rest);
  desk_->go_on(1.0);
  press(Key::rest);
  EXPECT_EQ(desk_->frame(), 6);  // time stood still
}

TEST_F(ADeskOfMarkers, TellsItsKeysAndEnds) {
  EXPECT_THAT(desk_->lines(""), Contains("F1  keys"));
  press(Key::help);
  EXPECT_THAT(desk_->lines(""), AllOf(Contains(HasSubstr("u  undo")), Contains(HasSubstr("e  residuals"))));
  press(Key::residuals);
  EXPECT_TRUE(desk_->shows_residuals());
  press(Key::quit);
  EXPECT_TRUE(desk_->ended());
}

TEST(ClickFinder, TellsClicksFromDrags) {
  ClickFinder finder;
  EXPECT_FALSE(finder.release({1.0, 1.0}));  // pressed elsewhere
  finder.press({10.0, 10.0});
  finder.move({12.0, 11.0});
  const auto click = finder.release({12.0, 11.0});
  ASSERT_TRUE(click);
  EXPECT_EQ(click->x, 10.0);
  EXPECT_FALSE(finder.held_from());
  finder.press({10.0, 10.0});
  finder.move({40.0, 10.0});
  ASSERT_TRUE(finder.held_from());
  EXPECT_EQ(finder.held_from()->x, 10.0);
  finder.move({10.0, 10.0});
  EXPECT_FALSE(finder.release({10.0, 10.0}));  // there and back
}

}  // namespace
}  // namespace rotunda::playback
