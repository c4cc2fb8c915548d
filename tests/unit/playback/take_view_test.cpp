#include "playback/take_view.h"

#include <gtest/gtest.h>

#include "playback/display/headless.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::playback {
namespace {

constexpr int kWidth = 160, kHeight = 120;
const cv::Vec3f kGreen(30, 200, 40);  // what the camera saw; stored is red where the eye looks

class ATakeView : public ::testing::Test {
 protected:
  static Eigen::Vector3d centre(double height) { return {0.0, 0.0, height}; }

  static recon::GeometryImage ball(double height) {
    auto image = test::round_geometry_image({.level = 5, .centre = centre(height).cast<float>()});
    image.normals.clear();  // as read to be drawn
    return image;
  }

  static SourceView picture_of_ball(double height) {
    auto camera = simulator::look_at({3.0, 0.0, height}, centre(height), 200, 160, 300.0, 300.0);
    const std::vector<tests::Ball> balls{{centre(height), 0.5}};
    const auto picture = tests::picture_of(camera, balls, cv::Vec3f(40, 70, 200),
                                           [](std::size_t, const Eigen::Vector3d&) { return kGreen; });
    return source_view({camera, picture.rgb, {picture.alpha}}, capture::Backdrop::blue);
  }

  cv::Mat drawn(double height, const DrawOptions& options = {}) {
    Orbit orbit;
    orbit.target = centre(height);
    target_.bind();
    view_.draw(orbit.viewpoint(kWidth, kHeight), centre(height), options);
    return target_.read_rgba();
  }
  static cv::Vec4b middle(const cv::Mat& rgba) { return rgba.at<cv::Vec4b>(kHeight / 2, kWidth / 2); }

  HeadlessDisplay display_;
  RenderTarget target_{kWidth, kHeight};
  TakeView view_;
};

TEST_F(ATakeView, DrawsStoredColoursOrThoseOfThePictures) {
  const std::vector<SourceView> views{picture_of_ball(0.5)};
  view_.show(ball(0.5));
  EXPECT_GT(middle(drawn(0.5))[0], 200);
  view_.show(ball(0.5), views);
  const auto seen = middle(drawn(0.5));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], kGreen[c], 6.0) << c;
  const auto bare = middle(drawn(0.5, {.shading = Shading::grey}));
  EXPECT_NEAR(bare[0], bare[1], 3.0);  // the bare shape is asked for: no picture on it
  view_.show(ball(0.5));
  EXPECT_GT(middle(drawn(0.5))[0], 200);
}

// Beside the ball, where the floor would be lit.
TEST_F(ATakeView, HasAFloorUnderWhoStandsOnItAlone) {
  const auto beside_below = [](const cv::Mat& rgba) { return rgba.at<cv::Vec4b>(kHeight - 20, kWidth / 2 + 25)[0]; };
  view_.show(ball(0.5));
  EXPECT_GT(beside_below(drawn(0.5)), 50);
  TakeView elsewhere;  // z = 0 of this calibration is no floor
  elsewhere.show(ball(0.8));
  std::swap(view_, elsewhere);
  EXPECT_LT(beside_below(drawn(0.8)), 40);
}

}  // namespace
}  // namespace rotunda::playback
