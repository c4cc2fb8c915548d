#include "playback/marker_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "playback/display/headless.h"
#include "playback/marker_window.h"
#include "playback/surface_pick.h"
#include "tests/support/template_person.h"
#include "tests/support/virtual_screen.h"
#include "tests/support/window_hand.h"

namespace rotunda::playback {
namespace {

namespace fs = std::filesystem;

class AnEditor : public testing::Test {
 protected:
  AnEditor()
      : motion_(recon::import_bvh(recon::parse_bvh(tests::bvh_text_with(90.0, 20.0)))), editor_(scan_, proposed()) {}

  static const recon::Markers& proposed() {  // once: fitting takes its time
    static const auto markers = [] {
      const auto scan = recon::prepare_scan(tests::scan_of(tests::someone()));
      return recon::propose_markers(scan.mesh, scan.from_triangle, recon::fit_template(scan.mesh));
    }();
    return markers;
  }

  PreviewWish wish(std::optional<int> frame, bool residuals = false) const {
    return {editor_.revision(), frame, residuals};
  }
  const recon::PreparedScan scan_ = recon::prepare_scan(tests::scan_of(tests::someone()));
  recon::BodyMotion motion_;
  recon::MarkerEditor editor_;
};

using APreviewOfMarkers = AnEditor;

TEST_F(APreviewOfMarkers, ShowsTheScanAsItWillMove) {
  MarkerPreview preview(scan_, *editor_.markers().fit, motion_);
  EXPECT_EQ(preview.newest()->scan.positions, scan_.mesh.positions);
  const auto moved = preview.wait_for(wish(1), editor_.markers());
  recon::ScanAnimation animation(scan_, editor_.markers());
  const auto poses = animation.handle_poses(motion_);
  std::vector<Eigen::Vector3f> positions(scan_.mesh.positions.size());
  animation.deform(std::span(poses).subspan(recon::kBodySegments, recon::kBodySegments), positions);
  EXPECT_EQ(moved->scan.positions, positions);
  EXPECT_EQ(moved->told, "");
  const auto rest = preview.wait_for(wish(std::nullopt, true), editor_.markers());
  EXPECT_EQ(rest->scan.positions, scan_.mesh.positions);
  ASSERT_EQ(rest->scan_residuals.size(), scan_.mesh.positions.size());
  ASSERT_EQ(rest->body_residuals.size(), rest->body.positions.size());
}

TEST_F(APreviewOfMarkers, FollowsEditsAndTellsMarkersThatCannotCarry) {
  MarkerPreview preview(scan_, *editor_.markers().fit, motion_);
  const auto before = preview.wait_for(wish(1), editor_.markers());
  const auto all = editor_.markers().pairs;
  auto trunkless = all;
  std::erase_if(trunkless, [](const auto& m) { return recon::segment_of_triangle(m.template_triangle) == 0; });
  editor_.replace(trunkless);
  const auto without = preview.wait_for(wish(1), editor_.markers());
  EXPECT_THAT(without->told, testing::HasSubstr("no marker on the pelvis"));
  EXPECT_EQ(without->scan.positions, before->scan.positions);  // as with the last that could
  auto fewer = all;
  std::erase_if(fewer, [](const auto& m) { return recon::segment_of_triangle(m.template_triangle) == 5; });
  editor_.replace(fewer);
  const auto other = preview.wait_for(wish(1), editor_.markers());
  EXPECT_EQ(other->told, "");
  EXPECT_NE(other->scan.positions, before->scan.positions);  // the forearm follows its neighbours
}

// The pixel of a picture that is red first.
recon::Colour at(const cv::Mat& rgba, int x, int y) {
  const auto& p = rgba.at<cv::Vec4b>(y, x);
  return {p[0], p[1], p[2]};
}

TEST_F(AnEditor, DrawsEveryDotWhereItsTrianglesAreOnBothSides) {
  const HeadlessDisplay display;
  const MarkerLayout layout{801, 600};
  const RenderTarget target(layout.width, layout.height);
  Orbit front{.target = {0.0, 0.0, 0.8}, .distance = 3.5, .elevation = 0.0};
  MarkerPreview preview(scan_, *editor_.markers().fit, motion_);
  MarkerView view;
  int looked_at = 0;
  for (const auto marker : std::vector(editor_.markers().pairs)) {
    if (marker.number % 5 != 0) continue;
    editor_.replace({marker});  // alone, so that no other lies over it
    MarkerDesk desk(editor_, {.frames = 3, .fps = 25.0}, front);
    view.show(preview.newest(), desk);
    target.bind();
    view.draw(desk, layout, {""});
    const auto drawn = target.read_rgba();
    for (const auto side : {MarkerSide::body, MarkerSide::scan}) {
      const auto& mesh = side == MarkerSide::body ? view.shown().body : view.shown().scan;
      const auto triangle = side == MarkerSide::body ? marker.template_triangle : editor_.on_prepared(marker);
      const auto eye = layout.viewpoint(side, desk.orbit());
      const auto pixel = *seen_at(eye, recon::middle_of(mesh, triangle).cast<double>());
      const auto hit = pick(mesh, eye, pixel.head<2>());
      if (pixel.y() < 80) continue;  // below the text
      const auto x = static_cast<int>(std::lround(pixel.x())) + layout.left(side);
      const auto y = static_cast<int>(std::lround(pixel.y()));
      const bool dot = at(drawn, x, y) == segment_colour(recon::segment_of_triangle(marker.template_triangle));
      // With its number a dot may be seen that lies five centimetres under a surface, as where segments meet.
      if (hit && hit->triangle == triangle) {
        EXPECT_TRUE(dot) << marker.number << " at " << x << ", " << y;
      } else if (hit && hit->depth < pixel.z() - 0.06) {
        EXPECT_FALSE(dot) << marker.number << " at " << x << ", " << y;
      }
      ++looked_at;
    }
  }
  EXPECT_GT(looked_at, 60);
}

TEST_F(AnEditor, ColoursBothSidesByTheirDistance) {
  const HeadlessDisplay display;
  const MarkerLayout layout{640, 480};
  const RenderTarget target(layout.width, layout.height);
  MarkerDesk desk(editor_, {.frames = 3, .fps = 25.0}, {.target = {0.0, 0.0, 0.8}, .distance = 3.5});
  MarkerPreview preview(scan_, *editor_.markers().fit, motion_);
  MarkerView view;
  const auto colourful = [&](bool residuals) {
    view.show(preview.wait_for(wish(std::nullopt, residuals), editor_.markers()), desk);
    target.bind();
    view.draw(desk, layout, {""});
    const auto drawn = target.read_rgba();
    int count = 0;
    for (int y = 0; y < drawn.rows; ++y)
      for (int x = 0; x < drawn.cols; ++x) {
        const auto [r, g, b] = at(drawn, x, y);
        count += std::max({r, g, b}) - std::min({r, g, b}) > 40;
      }
    return count;
  };
  EXPECT_GT(colourful(true), 3 * colourful(false));  // without: the dots alone
}

TEST_F(AnEditor, IsAPictureWithoutAWindow) {
  const auto picture = picture_of_markers(scan_, editor_, motion_, 320, 200);
  EXPECT_EQ(picture.size(), cv::Size(320, 400));
  EXPECT_EQ(picture.type(), CV_8UC3);
  cv::Mat difference;
  cv::absdiff(picture.rowRange(0, 200), picture.rowRange(200, 400), difference);
  EXPECT_GT(cv::countNonZero(difference.reshape(1)), 1000);  // as scanned, and in the motion
}

class AnEditorInAWindow : public AnEditor {
 protected:
  AnEditorInAWindow() {
    fs::create_directories(folder_);
    ::setenv("DISPLAY", screen_.display().c_str(), 1);
  }
  ~AnEditorInAWindow() override {
    fs::remove_all(folder_);
    ::unsetenv("DISPLAY");
  }
  // The window as hands use it; `hands` are in a thread of their own, and end it with q.
  EditMarkersReport edit(const std::function<void(tests::WindowHand&)>& hands) {
    const std::jthread thread([&] {
      tests::WindowHand hand(screen_.display(), "rotunda: markers markers.yaml");
      hands(hand);
      hand.press(XK_q);
    });
    return edit_markers(scan_, editor_, keeper_, motion_, {.width = kWidth, .height = kHeight});
  }

  static constexpr int kWidth = 601, kHeight = 400;
  const HeadlessDisplay driver_;  // Mesa's driver stays loaded with it (player_test)
  const tests::VirtualScreen screen_;
  fs::path folder_ = fs::temp_directory_path() / ("rotunda_marker_view_" + std::to_string(::getpid()));
  recon::MarkerKeeper keeper_{folder_ / "markers.yaml", "scan.ply"};
};

TEST_F(AnEditorInAWindow, TakesKeysAndSaves) {
  const auto before = editor_.markers().pairs;
  edit([](tests::WindowHand& hand) {
    hand.press(XK_b);  // one side
    hand.press(XK_Tab);
    hand.press(XK_Delete);
    hand.press(XK_Tab);
    hand.press(XK_x);
    hand.press(XK_z, ControlMask);
    hand.press(XK_s);
  });
  const std::vector<recon::Marker> wanted(before.begin() + 1, before.end());
  EXPECT_EQ(recon::read_markers(keeper_.file()).pairs, wanted);
  EXPECT_FALSE(keeper_.left());
}

TEST_F(AnEditorInAWindow, MakesPairsOfClicksAndKeepsThemUnsaved) {
  const auto before = editor_.markers().pairs;
  // The middle of a half shows the middle of the scan's box, a hand's breadth beside the crotch: the belly.
  edit([&](tests::WindowHand& hand) {
    hand.press(XK_n);
    hand.click(kWidth / 4 + 4, kHeight / 2 - 30);
    hand.click(kWidth / 2 + kWidth / 4 + 4, kHeight / 2 - 30);
  });
  const auto& pairs = editor_.markers().pairs;
  if (pairs.size() == before.size()) FAIL() << "no pair was made";
  const auto& made = pairs.at(before.size());
  const auto posed = recon::pose_template(editor_.markers().fit->body, editor_.markers().fit->pose);
  EXPECT_LT((recon::middle_of(posed, made.template_triangle) - recon::middle_of(scan_.mesh, editor_.on_prepared(made)))
                .norm(),
            0.05F);
  EXPECT_FALSE(fs::exists(keeper_.file()));
  ASSERT_TRUE(keeper_.left());
  EXPECT_EQ(keeper_.left()->pairs, pairs);
}

TEST_F(AnEditorInAWindow, ScrubsAndTurnsByDraggingAndThatIsNoClick) {
  const auto before = editor_.markers().pairs;
  const auto report = edit([](tests::WindowHand& hand) {
    hand.press(XK_Tab);
    hand.drag(kWidth / 4 + 4, kHeight / 2, kWidth / 4 + 60, kHeight / 2);  // over the body: the eye goes round
    hand.drag(5, kHeight - 5, kWidth / 2, kHeight - 50);                   // from the bar: the middle of three frames
  });
  EXPECT_EQ(report.frame, 1);
  EXPECT_EQ(editor_.markers().pairs, before);
}

TEST_F(AnEditorInAWindow, EndsAtItsLimitOfPictures) {
  EXPECT_EQ(edit_markers(scan_, editor_, keeper_, motion_, {.width = 320, .height = 240, .picture_limit = 5}).pictures,
            5);
}

}  // namespace
}  // namespace rotunda::playback
