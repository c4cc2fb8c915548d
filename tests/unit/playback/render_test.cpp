#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "capture/camera_model.h"
#include "capture/picture.h"
#include "config/errors.h"
#include "playback/display/headless.h"
#include "playback/render/geometry_image_renderer.h"
#include "playback/render/mesh_renderer.h"
#include "playback/viewpoint.h"
#include "recon/video/geometry_video.h"
#include "simulator/studio/camera_layout.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::playback {
namespace {

using recon::GeometryImage;
using recon::TriangleMesh;

// The image's surface as a mesh of its own, cut along the octahedron's edges; colours at the positions' samples.
TriangleMesh mesh_of(const GeometryImage& image) {
  TriangleMesh mesh{.positions = image.positions, .normals = image.normals, .colours = {}, .triangles = {}};
  const auto side = static_cast<std::uint32_t>(image.side()), half = side / 2;
  const std::uint32_t step = 1U << (image.colour_level - image.level);
  for (std::uint32_t row = 0; row < side; ++row)
    for (std::uint32_t column = 0; column < side; ++column) {
      mesh.colours.push_back(
          image.colours[row * step * static_cast<std::uint32_t>(image.colour_side()) + column * step]);
      if (row + 1 == side || column + 1 == side) continue;
      const std::uint32_t a = row * side + column, b = a + 1, c = a + side, d = c + 1;
      if ((row < half) == (column < half)) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({a, d, c});
      }
    }
  return mesh;
}

struct Disc {
  Eigen::Vector2d centre;  // pixels
  double area;             // pixels
};

Disc disc_of(const cv::Mat& rgba) {
  Disc disc{Eigen::Vector2d::Zero(), 0.0};
  for (int y = 0; y < rgba.rows; ++y)
    for (int x = 0; x < rgba.cols; ++x)
      if (rgba.at<cv::Vec4b>(y, x)[3] == 255) {
        disc.centre += Eigen::Vector2d(x, y);
        disc.area += 1.0;
      }
  disc.centre /= disc.area;
  return disc;
}

// The outline of a ball through a camera in closed form: where the rays that touch it meet the picture.
Disc outline_of_ball(const capture::CameraModel& camera, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d axis = centre - camera.centre();
  const double distance = axis.norm(), half_angle = std::asin(radius / distance);
  const Eigen::Vector3d along = axis / distance, aside = along.unitOrthogonal(), across = along.cross(aside);
  std::vector<cv::Point2d> outline;
  for (int i = 0; i < 720; ++i) {
    const double turn = i * CV_PI / 360.0;
    const Eigen::Vector3d ray =
        std::cos(half_angle) * along + std::sin(half_angle) * (std::cos(turn) * aside + std::sin(turn) * across);
    const auto pixel = capture::project(camera, camera.centre() + ray);
    outline.emplace_back(pixel->x(), pixel->y());
  }
  double area = 0.0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto &p = outline[i], &q = outline[(i + 1) % outline.size()];
    const double wedge = p.x * q.y - q.x * p.y;
    area += 0.5 * wedge;
    centroid += wedge / 6.0 * Eigen::Vector2d(p.x + q.x, p.y + q.y);
  }
  return {centroid / area, std::abs(area)};
}

double radius_of(double area) {
  return std::sqrt(area / CV_PI);
}

class Render : public ::testing::Test {
 protected:
  HeadlessDisplay display_;
};

capture::CameraModel odd_camera() {
  auto camera = simulator::look_at({2.5, -1.5, 1.6}, {0.1, 0.1, 1.1}, 320, 240, 260.0, 260.0 * 16.0 / 15.0);
  camera.K(0, 1) = 12.0;  // skew
  camera.K(0, 2) += 9.0;
  return camera;
}

void expect_the_outline(const capture::CameraModel& camera, const cv::Mat& picture, const Eigen::Vector3d& centre,
                        double radius) {
  const Disc expected = outline_of_ball(camera, centre, radius), found = disc_of(picture);
  EXPECT_LT((found.centre - expected.centre).norm(), 0.1);  // the ball's pixels average to far less than one
  EXPECT_NEAR(radius_of(found.area), radius_of(expected.area), 0.15);
}

TEST_F(Render, SeesExactlyWhatTheCameraSees) {
  const GeometryImage ball = test::round_geometry_image({.level = 7, .colour_level = 7});
  const Eigen::Vector3d centre(0.3, -0.2, 1.0);
  auto skewed = odd_camera(), distorted = odd_camera(), mirrored = odd_camera();
  distorted.distortion << -0.25, 0.08, 0.004, -0.003, 0.01;
  mirrored.R.row(0) *= -1.0;  // a left-handed set
  mirrored.t[0] *= -1.0;
  for (const auto& camera : {skewed, distorted, mirrored}) {
    expect_the_outline(camera, render_geometry_image(ball, viewpoint_of(camera)), centre, 0.5);
    expect_the_outline(camera, render_mesh(mesh_of(ball), viewpoint_of(camera)), centre, 0.5);
  }
}

TEST_F(Render, ShowsTheNearSide) {
  const GeometryImage ball = test::round_geometry_image({.level = 6, .colour_level = 7});
  auto mirrored = odd_camera();
  mirrored.R.row(0) *= -1.0;
  mirrored.t[0] *= -1.0;
  for (const auto& camera : {odd_camera(), mirrored}) {
    // The colour tells the direction from the ball's middle; in the picture's middle of it that is towards the eye.
    const Eigen::Vector3d centre(0.3, -0.2, 1.0);
    const Eigen::Vector3d towards_eye = (camera.centre() - centre).normalized();
    const auto pixel = capture::project(camera, centre + 0.5 * towards_eye);
    const auto expected = test::direction_colour(towards_eye.cast<float>());
    for (const bool cull : {true, false})
      for (const cv::Mat& picture : {render_geometry_image(ball, viewpoint_of(camera), {.cull = cull}),
                                     render_mesh(mesh_of(ball), viewpoint_of(camera), {.cull = cull})}) {
        const auto seen = picture.at<cv::Vec4b>(cvRound(pixel->y()), cvRound(pixel->x()));
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(seen[i], expected[static_cast<std::size_t>(i)], 3) << cull << i;
      }
  }
}

TEST_F(Render, CullingChangesNoPixelOfAClosedSurface) {
  const GeometryImage ball = test::round_geometry_image({.level = 6, .colour_level = 7});
  const Viewpoint view = viewpoint_of(odd_camera());
  const cv::Mat culled = render_geometry_image(ball, view), whole = render_geometry_image(ball, view, {.cull = false});
  cv::Mat differing;
  cv::absdiff(culled, whole, differing);
  EXPECT_LT(cv::countNonZero(differing.reshape(1)), 100);  // of 307200: hairs along the outline
}

TEST_F(Render, GeometryImageAndItsMeshLookTheSame) {
  const GeometryImage body = test::round_geometry_image({.level = 6, .colour_level = 6, .radii = {0.3F, 0.5F, 0.9F}});
  const Viewpoint view = viewpoint_of(odd_camera());
  for (const Shading shading : {Shading::colour, Shading::grey}) {
    const cv::Mat image = render_geometry_image(body, view, {.shading = shading});
    const cv::Mat mesh = render_mesh(mesh_of(body), view, {.shading = shading});
    int alike = 0;
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const auto p = image.at<cv::Vec4b>(y, x), q = mesh.at<cv::Vec4b>(y, x);
        int worst = 0;
        for (int i = 0; i < 4; ++i) worst = std::max(worst, std::abs(p[i] - q[i]));
        alike += worst <= 6;  // bilinear in the lattice against linear in the triangle
      }
    EXPECT_GT(alike, image.rows * image.cols * 0.995);
  }
}

TEST_F(Render, StripsAreTheClosedLattice) {
  for (const int level : {1, 2, 5}) {
    const GeometryImage ball = test::round_geometry_image({.level = level, .colour_level = level});
    const auto strips = lattice_strips(level);
    TriangleMesh mesh{.positions = ball.positions, .normals = {}, .colours = {}, .triangles = {}};
    std::size_t start = 0;
    for (std::size_t i = 0; i < strips.size(); ++i) {
      if (strips[i] == 0xffffffffU) start = i + 1;
      if (i < start + 2 || strips[i] == 0xffffffffU) continue;
      const bool odd = (i - start) % 2 == 1;
      const std::array<std::uint32_t, 3> triangle{strips[i - (odd ? 1 : 2)], strips[i - (odd ? 2 : 1)], strips[i]};
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2]) mesh.triangles.push_back(triangle);
    }
    const auto expected = mesh_of(ball);
    ASSERT_EQ(mesh.triangles.size(), std::size_t{2} << (2 * level));
    EXPECT_NEAR(recon::signed_volume(mesh), recon::signed_volume(expected), 1e-6);
    EXPECT_GT(recon::signed_volume(mesh), 0.0);
    EXPECT_NEAR(recon::surface_area(mesh), recon::surface_area(expected), 1e-6);
  }
}

TEST_F(Render, CoarserLevelsKeepTheOutline) {
  const auto camera = odd_camera();
  const GeometryImage ball = test::round_geometry_image({.level = 7, .colour_level = 7});
  const RenderTarget target(camera.width, camera.height);
  GeometryImageRenderer renderer;
  renderer.upload(ball);
  const double expected = radius_of(outline_of_ball(camera, {0.3, -0.2, 1.0}, 0.5).area);
  for (const int level : {7, 6, 5, 4}) {
    target.bind();
    clear(std::nullopt);
    renderer.draw(viewpoint_of(camera), {}, level);
    // A chord of the coarsest lattice's 128 about the ball lies 0.3 % inside it, 2 % where its samples are sparse.
    EXPECT_NEAR(radius_of(disc_of(target.read_rgba()).area), expected, level >= 6 ? 0.3 : 0.02 * expected) << level;
  }
}

TEST_F(Render, TexturesOfThreeFramesDoNotMix) {
  const RenderTarget target(64, 64);
  GeometryImageRenderer renderer;
  const auto camera = simulator::look_at({3.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, 64, 64, 50.0, 50.0);
  for (int i = 0; i < 7; ++i) {
    GeometryImage ball = test::round_geometry_image({.level = 3 + i % 2, .colour_level = 4, .centre = {0, 0, 1}});
    for (auto& colour : ball.colours) colour = {static_cast<std::uint8_t>(30 * i), 200, 10};
    renderer.upload(ball);
    target.bind();
    clear(recon::Colour{1, 2, 3});
    renderer.draw(viewpoint_of(camera));
    const cv::Mat picture = target.read_rgba();
    EXPECT_EQ(picture.at<cv::Vec4b>(32, 32), cv::Vec4b(static_cast<std::uint8_t>(30 * i), 200, 10, 255));
    EXPECT_EQ(picture.at<cv::Vec4b>(0, 0), cv::Vec4b(1, 2, 3, 255));
  }
}

// A ball that grows, moves and reddens, played at a third of its rate, with a jump back at the end.
TEST_F(Render, DrawsWhatLiesBetweenTwoFrames) {
  const RenderTarget target(160, 120);
  const auto camera = simulator::look_at({3.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, 160, 120, 90.0, 90.0);
  std::vector<GeometryImage> frames;
  for (int i = 0; i < 5; ++i) {
    const float f = static_cast<float>(i);
    frames.push_back(test::round_geometry_image({.level = 5,
                                                 .colour_level = 5,
                                                 .centre = {0.0F, 0.1F * f - 0.2F, 1.0F},
                                                 .radii = Eigen::Vector3f::Constant(0.3F + 0.04F * f)}));
    for (auto& colour : frames.back().colours) colour = {static_cast<std::uint8_t>(50 * i), 120, 10};
  }
  const auto picture_of = [&](GeometryImageRenderer& renderer) {
    target.bind();
    clear(std::nullopt);
    renderer.draw(viewpoint_of(camera));
    return target.read_rgba();
  };
  GeometryImageRenderer between, blended;
  for (const int third : {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1, 11}) {
    const auto frame = static_cast<std::size_t>(third / 3);
    const double share = third % 3 / 3.0;
    between.upload_between({frames[frame], third / 3}, {frames[frame + 1], third / 3 + 1}, share);
    auto expected = frames[frame];
    recon::blend(expected, frames[frame + 1], static_cast<float>(share));
    blended.upload(expected);
    const cv::Mat shown = picture_of(between), right = picture_of(blended);
    cv::Mat off;
    cv::absdiff(shown, right, off);
    cv::Mat wrong;
    cv::inRange(off, cv::Scalar::all(0), cv::Scalar::all(1), wrong);
    EXPECT_LE(cv::countNonZero(wrong == 0), 12) << third;  // pixels of the rim that rounding decides
    EXPECT_GT(disc_of(shown).area, 200.0);
  }
}

TEST_F(Render, RefusesToDrawBetweenUnlikeLevels) {
  const GeometryImage fine = test::round_geometry_image({.level = 5}),
                      coarse = test::round_geometry_image({.level = 4});
  GeometryImageRenderer renderer;
  EXPECT_THROW(renderer.upload_between({fine, 0}, {coarse, 1}, 0.5), InvalidInput);
}

TEST_F(Render, RefusesWhatIsNotWhole) {
  GeometryImage ball = test::round_geometry_image();
  ball.positions.pop_back();
  EXPECT_THROW(render_geometry_image(ball, viewpoint_of(odd_camera())), InvalidInput);
  TriangleMesh mesh = mesh_of(test::round_geometry_image());
  mesh.triangles.push_back({0, 1, 5000});
  EXPECT_THROW(render_mesh(mesh, viewpoint_of(odd_camera())), InvalidInput);
  mesh = mesh_of(test::round_geometry_image());
  mesh.colours.pop_back();
  EXPECT_THROW(render_mesh(mesh, viewpoint_of(odd_camera())), InvalidInput);
  EXPECT_EQ(disc_of(render_mesh({}, viewpoint_of(odd_camera()))).area, 0.0);
}

TEST(Orbit, HoldsTheWholeBoxInThePictureFromEverywhere) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-0.6, -0.4, 0.0), Eigen::Vector3d(0.6, 0.5, 1.8));
  Orbit orbit = orbit_around(box);
  for (int step = 0; step < 24; ++step) {
    orbit.turn(0.3, 0.0);
    const Viewpoint view = orbit.viewpoint(640, 360);
    EXPECT_NEAR((view.eye() - orbit.target).norm(), orbit.distance, 1e-9);
    EXPECT_FALSE(view.mirrored());
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d p = view.R * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) + view.t;
      const Eigen::Vector3d pixel = view.K * p / p.z();
      EXPECT_GT(pixel.minCoeff(), -0.5);
      EXPECT_LT(pixel.x(), 639.5);
      EXPECT_LT(pixel.y(), 359.5);
    }
  }
}

TEST(Orbit, KeepsUpUp) {
  Orbit orbit;
  orbit.turn(1.0, 10.0);  // over the top: stopped short of it
  const Viewpoint view = orbit.viewpoint(640, 480);
  EXPECT_LT(orbit.elevation, 1.5);
  EXPECT_LT((view.R * Eigen::Vector3d::UnitZ()).y(), 0.0);  // the picture's y points down
  EXPECT_NEAR((view.R * view.R.transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace rotunda::playback
