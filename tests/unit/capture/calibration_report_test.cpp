#include "capture/calibration/calibration_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "capture/calibration/html_page.h"
#include "capture/calibration/view_drawing.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Two cameras, three moments, one board; residuals of 0.2 px, one outlier.
CalibrationResult small_result(const std::filesystem::path& picture) {
  CalibrationResult result;
  for (int i = 0; i < 2; ++i) {
    CameraModel camera{.name = i == 0 ? "cam00" : "<cam&01>", .width = 640, .height = 480};
    camera.K << 600, 0, 320, 0, 600, 240, 0, 0, 1;
    camera.t = {0.5 * i, 0, 3};
    result.cameras.push_back(camera);
    CameraQuality quality{.views = 3, .corners = 45, .outliers = i, .rms_px = 0.2, .p95_px = 0.4};
    quality.coverage.corners.assign(48, 3);
    quality.coverage.corners[5] = 0;
    result.quality.push_back(quality);
  }
  result.quality[1].verdict = result.verdict = Verdict::usable;
  result.quality[1].advice = {"<cam&01> saw the board 3 times: show it upper right"};
  result.moments = {"m0", "m1", "m2"};
  result.boards = {Board{}};
  for (std::size_t moment = 0; moment < 3; ++moment) {
    result.poses.push_back(
        {moment, 0, Eigen::Isometry3d(Eigen::Translation3d(0.1 * static_cast<double>(moment), 0, 0))});
    for (std::size_t camera = 0; camera < 2; ++camera) {
      CalibratedView view{.camera = camera, .moment = moment, .board = 0, .picture = picture, .rms_px = 0.2};
      for (int c = 0; c < 15; ++c)
        view.corners.push_back({c, {100.0 + 20 * c, 150.0}, {0.2, 0.0}, camera == 1 && c == 0});
      result.views.push_back(view);
    }
  }
  result.ties = {{0, 1, 3, 0.5, 0.001}};
  result.world = "the board on the floor";
  return result;
}

TEST(CalibrationReport, IsOneWholePageThatNeedsNothingElse) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "m0.png", cv::Mat(480, 640, CV_8UC3, cv::Scalar(90, 120, 200)));
  const auto html = calibration_report(small_result(folder.path() / "m0.png"), {.title = "Studio A"});
  EXPECT_THAT(html, HasSubstr("<title>Studio A</title>"));
  EXPECT_THAT(html, HasSubstr("show it upper right"));
  EXPECT_THAT(html, HasSubstr("data:image/jpeg;base64,/9j/"));
  for (const auto* outside : {"http:", "https:", "src=\"/", "file:", "<cam&", "nan"})
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  // Every element that is opened is closed, in order.
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::string tag = html.substr(at + 1, html.find('>', at) - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" /", 1));
    if (tag.back() == '/' || tag[0] == '!' || name == "meta" || name == "br") continue;
    if (tag[0] != '/') {
      open.push_back(name);
      continue;
    }
    ASSERT_FALSE(open.empty());
    ASSERT_EQ("/" + open.back(), tag);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
}

TEST(CalibrationReport, ArrowsPointFromFoundToCalibratedAndAreMagnifiedAlike) {
  const auto result = small_result({});
  EXPECT_EQ(residual_magnification(result), 200.0);  // 0.2 px of 640 x 200 = 1/16 of the width, x 500 would be 0.16
  // The first corner is at (100, 150), at half size (50.25, 75.25); found 0.2 px too far right, so 20 drawn to the
  // left.
  EXPECT_THAT(draw_view(result, result.views[0], 200.0, 320), HasSubstr("M50.2 75.2L30.2 75.2"));
}

TEST(CalibrationReport, WithoutItsPicturesIsGrey) {
  EXPECT_THAT(calibration_report(small_result("gone.png")), Not(HasSubstr("data:image")));
}

TEST(CalibrationReport, OfAResultThatDoesNotFitItselfIsRefused) {
  auto result = small_result({});
  result.views[1].moment = 9;
  EXPECT_THROW(calibration_report(result), InvalidInput);
}

TEST(HtmlPage, Base64IsTheRfcs) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace rotunda::capture
