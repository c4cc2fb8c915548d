#include "recon/colour/colour_samples.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>

#include "capture/srgb.h"
#include "config/errors.h"
#include "recon/colour/surface_colour.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/ball_scene.h"

namespace rotunda::recon {
namespace {

const tests::Ball kBall{.centre = {0.0, 0.1, 1.0}, .radius = 0.6};

cv::Vec3f paint(std::size_t, const Eigen::Vector3d& point) {
  return {static_cast<float>(130 + 80 * std::sin(3.0 * point.x())),
          static_cast<float>(120 + 70 * std::sin(4.0 * point.z() + 1.0)),
          static_cast<float>(100 + 60 * std::sin(3.5 * point.y()))};
}

// What camera i makes of the light.
Eigen::Matrix3d response(std::size_t i) {
  const double s = static_cast<double>(i) - 2.0;
  Eigen::Matrix3d matrix = Eigen::Vector3d(1.0 + 0.07 * s, 1.0 - 0.02 * s, 1.0 - 0.06 * s).asDiagonal();
  matrix(0, 1) = 0.03 * s;
  return matrix;
}

class ColourSamples : public testing::Test {
 protected:
  ColourSamples() {
    tests::append_ball(kBall, 40, ball_);
    const auto cameras = simulator::camera_layout({.cameras = 5, .width = 200, .height = 160});
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const auto picture = tests::picture_of(cameras[i], std::span(&kBall, 1), {30, 60, 190}, paint);
      views_.cameras.push_back(cameras[i]);
      views_.pictures.push_back(capture::with_matrix(picture.rgb, response(i)));
      views_.mattes.push_back({picture.alpha});
      names_.push_back(cameras[i].name);
    }
  }
  SurfaceColour coloured(const std::vector<Eigen::Matrix3d>& colour) const {
    std::vector<ColourView> views;
    for (std::size_t i = 0; i < names_.size(); ++i)
      views.push_back({views_.cameras[i], views_.pictures[i], views_.mattes[i], colour[i]});
    return surface_colour(ball_.positions, ball_.normals, ball_, views, {.remove_spill = false});
  }

  TriangleMesh ball_;
  FrameViews views_;
  std::vector<std::string> names_;
};

TEST_F(ColourSamples, MakeCamerasAgreeAndTheSurfaceCleaner) {
  const auto samples =
      colour_samples(ball_, views_, names_, 0, {.points = 4000, .least_inside_px = 3, .half_window = 1});
  ASSERT_GT(samples.size(), 500U);
  const auto match = capture::match_colours(names_, samples);
  EXPECT_GT(match.before, 6.0);
  EXPECT_LT(match.after, 1.5);  // pixels off by half a pixel of a smooth paint, and whole levels

  // With the true responses undone up to the mean camera, the same surface comes out: what recon applies.
  std::vector<Eigen::Matrix3d> found, none(names_.size(), Eigen::Matrix3d::Identity());
  for (const auto& camera : match.cameras) found.push_back(camera.matrix);
  const auto error = [&](const SurfaceColour& colour) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t v = 0; v < ball_.positions.size(); ++v)
      if (colour.coverage[v]) {
        const auto truth = paint(0, ball_.positions[v].cast<double>());
        for (int c = 0; c < 3; ++c) sum += std::abs(colour.colours[v][static_cast<std::size_t>(c)] - truth[c]), ++count;
      }
    return sum / count;
  };
  EXPECT_LT(error(coloured(found)), 0.5 * error(coloured(none)));
}

TEST_F(ColourSamples, ComeFromPointsThatAreSeen) {
  std::set<std::size_t> places;
  for (const auto& sample :
       colour_samples(ball_, views_, names_, 1000, {.points = 1000, .least_inside_px = 3, .half_window = 1})) {
    places.insert(sample.place);
    const auto& camera = views_.cameras[sample.camera];
    const Eigen::Vector3d point = ball_.positions[sample.place - 1000].cast<double>();
    EXPECT_GT((camera.centre() - point).dot(point - kBall.centre), 0.0);
    const cv::Vec3f painted = paint(0, point);
    const Eigen::Vector3d truth =
        response(sample.camera) * capture::linear_of(cv::Vec3b(cv::saturate_cast<std::uint8_t>(painted[0]),
                                                               cv::saturate_cast<std::uint8_t>(painted[1]),
                                                               cv::saturate_cast<std::uint8_t>(painted[2])));
    EXPECT_LT((sample.linear - truth).cwiseAbs().maxCoeff(), 0.03);
  }
  EXPECT_GT(places.size(), 50U);
  EXPECT_THROW(colour_samples(ball_, views_, std::vector<std::string>{"other"}, 0), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
