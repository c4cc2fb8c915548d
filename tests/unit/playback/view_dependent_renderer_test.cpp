#include "playback/render/view_dependent_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "config/errors.h"
#include "playback/display/headless.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"

namespace rotunda::playback {
namespace {

using tests::Ball;

constexpr int kHeld = 8;  // cameras of the scene; those after them are held out
const cv::Vec3f kPaint(40, 70, 200);
const recon::Colour kOwn{255, 0, 255};  // of the surface's own: nothing in the scene looks like it

// A big ball with a grey pattern, a small red one 25 cm before it: to some cameras it hides a part that others see.
const std::vector<Ball> kBalls{{{0.0, 0.0, 1.0}, 0.45}, {{0.75, 0.1, 1.05}, 0.08}};

cv::Vec3f colour_at(std::size_t ball, const Eigen::Vector3d& place) {
  if (ball == 1) return {220, 50, 30};
  const double pattern = std::sin(30.0 * place.x()) * std::sin(30.0 * place.y()) * std::sin(30.0 * place.z());
  return cv::Vec3f::all(static_cast<float>(140.0 + 60.0 * pattern));
}

capture::CameraModel camera_at(double azimuth, double height, int width, int height_px) {
  const Eigen::Vector3d eye(2.5 * std::cos(azimuth), 2.5 * std::sin(azimuth), height);
  auto camera = simulator::look_at(eye, {0.0, 0.0, 1.0}, width, height_px, 1.9 * height_px, 1.9 * height_px);
  camera.name = "eye";
  return camera;
}

struct Scene {
  recon::TriangleMesh surface;
  std::vector<capture::CameraModel> cameras;
  std::vector<tests::BallPicture> pictures;
  std::vector<SourceView> sources;
};

// Every other camera is half as large; all have a distorting lens.
const Scene& scene() {
  static const Scene made = [] {
    Scene scene;
    for (const auto& ball : kBalls) tests::append_ball(ball, 60, scene.surface);
    scene.surface.colours.assign(scene.surface.positions.size(), kOwn);
    for (int i = 0; i < kHeld; ++i) {
      auto camera = i % 2 == 0 ? camera_at(i * M_PI / 4.0, 1.3, 320, 256) : camera_at(i * M_PI / 4.0, 1.6, 160, 128);
      camera.distortion << -0.08, 0.02, 0.001, -0.001, 0.0;
      scene.cameras.push_back(camera);
    }
    for (const auto& camera : scene.cameras) {
      scene.pictures.push_back(tests::picture_of(camera, kBalls, kPaint, colour_at));
      const auto& picture = scene.pictures.back();
      scene.sources.push_back(source_view({camera, picture.rgb, {picture.alpha}}, capture::Backdrop::blue));
    }
    return scene;
  }();
  return made;
}

const capture::CameraModel& held_out() {
  static const auto camera = camera_at(M_PI / 8.0, 1.4, 320, 256);
  return camera;
}

// Over the pixels of `mask`.
double rms(const cv::Mat& rgba, const cv::Mat& truth, const cv::Mat& mask) {
  cv::Mat rgb;
  cv::cvtColor(rgba, rgb, cv::COLOR_RGBA2RGB);
  return cv::norm(rgb, truth, cv::NORM_L2, mask) / std::sqrt(3.0 * cv::countNonZero(mask));
}

cv::Mat well_inside(const cv::Mat& alpha, int pixels) {
  cv::Mat inside;
  cv::erode(alpha == 255, inside, cv::Mat::ones(2 * pixels + 1, 2 * pixels + 1, CV_8UC1));
  return inside;
}

class ViewDependent : public ::testing::Test {
  HeadlessDisplay display_;
};

}  // namespace

// The pattern swings by 60 of 255; pixels of 7 mm in the coarser cameras, bilinearly, leave 4.
TEST_F(ViewDependent, SeesWhatACameraThereWouldHaveSeen) {
  const auto truth = tests::picture_of(held_out(), kBalls, kPaint, colour_at);
  const auto drawn = render_view_dependent(scene().surface, scene().sources, viewpoint_of(held_out()));
  EXPECT_LT(rms(drawn, truth.rgb, well_inside(truth.alpha, 3)), 6.0);
}

// But for pixels beside the small ball's outline, where its picture mixes both and others are asked.
TEST_F(ViewDependent, GivesACameraItsOwnPictureBack) {
  const auto drawn = render_view_dependent(scene().surface, scene().sources, viewpoint_of(scene().cameras[0]));
  EXPECT_LT(rms(drawn, scene().pictures[0].rgb, well_inside(scene().pictures[0].alpha, 4)), 3.0);
}

// Without the depth maps the small ball's red would be painted on the big one behind it.
TEST_F(ViewDependent, ThrowsNoGhostOfAnOccluderOnWhatLiesBehind) {
  const auto drawn = render_view_dependent(scene().surface, scene().sources, viewpoint_of(held_out()));
  const auto truth = tests::picture_of(held_out(), kBalls, kPaint, colour_at);
  int red = 0, big = 0;
  cv::Mat small(truth.rgb.size(), CV_8UC1), near;
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      const auto& colour = truth.rgb.at<cv::Vec3b>(y, x);
      small.at<std::uint8_t>(y, x) = colour[0] > colour[1] + 20 ? 255 : 0;
    }
  ASSERT_GT(cv::countNonZero(small), 100);
  cv::dilate(small, near, cv::Mat::ones(5, 5, CV_8UC1));
  const cv::Mat inside = well_inside(truth.alpha, 2);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      if (near.at<std::uint8_t>(y, x) || !inside.at<std::uint8_t>(y, x)) continue;
      const auto& colour = drawn.at<cv::Vec4b>(y, x);
      ++big;
      red += colour[0] > colour[1] + 25;
    }
  EXPECT_GT(big, 5000);
  EXPECT_EQ(red, 0);
}

TEST_F(ViewDependent, HasNoBlueFringe) {
  const auto drawn = render_view_dependent(scene().surface, scene().sources, viewpoint_of(held_out()));
  int blue = 0;
  for (const auto& colour : cv::Mat_<cv::Vec4b>(drawn))
    blue += colour[3] > 0 && colour[2] > std::max(colour[0], colour[1]) + 12 && colour[0] < 230;
  EXPECT_EQ(blue, 0);
}

TEST_F(ViewDependent, KeepsTheSurfacesOwnColourWhereNoCameraSeesIt) {
  const std::vector<SourceView> front{scene().sources[0], scene().sources[1]};
  const auto from_behind = viewpoint_of(camera_at(M_PI * 1.125, 1.4, 160, 128));
  const auto drawn = render_view_dependent(scene().surface, front, from_behind);
  const auto& middle = drawn.at<cv::Vec4b>(64, 80);
  EXPECT_EQ(middle, cv::Vec4b(kOwn[0], kOwn[1], kOwn[2], 255));
}

TEST_F(ViewDependent, IsTheSameEveryTimeAndLeavesABackgroundAlone) {
  const auto viewpoint = viewpoint_of(held_out());
  const recon::Colour background{1, 2, 3};
  const auto once = render_view_dependent(scene().surface, scene().sources, viewpoint, background);
  const auto again = render_view_dependent(scene().surface, scene().sources, viewpoint, background);
  EXPECT_EQ(cv::norm(once, again, cv::NORM_INF), 0.0);
  EXPECT_EQ(once.at<cv::Vec4b>(0, 0), cv::Vec4b(1, 2, 3, 255));
}

TEST_F(ViewDependent, RefusesWhatCannotBeDrawn) {
  ViewDependentRenderer renderer;
  auto bare = scene().surface;
  bare.colours.clear();
  auto beyond = scene().surface;
  beyond.triangles.push_back({0, 1, static_cast<std::uint32_t>(beyond.positions.size())});
  auto other_size = scene().sources;
  other_size[1].rgba = other_size[0].rgba;
  EXPECT_THROW(renderer.upload(bare, scene().sources), InvalidInput);
  EXPECT_THROW(renderer.upload(beyond, scene().sources), InvalidInput);
  EXPECT_THROW(renderer.upload(scene().surface, {}), InvalidInput);
  EXPECT_THROW(renderer.upload(scene().surface, other_size), InvalidInput);
  EXPECT_THROW(source_view({held_out(), cv::Mat(4, 4, CV_8UC3), {}}, capture::Backdrop::blue), InvalidInput);
}

}  // namespace rotunda::playback
