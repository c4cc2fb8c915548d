#include "playback/surface_pick.h"

#include <gtest/gtest.h>

#include <random>

#include "playback/display/headless.h"
#include "playback/render/mesh_renderer.h"
#include "tests/support/template_person.h"

namespace rotunda::playback {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Looks along +x from the origin: a square wall across, cut by its rising diagonal.
recon::TriangleMesh wall(float x, float half) {
  return {.positions = {{x, half, -half}, {x, -half, -half}, {x, -half, half}, {x, half, half}},
          .triangles = {{0, 1, 2}, {0, 2, 3}}};
}
Viewpoint along_x(int width, int height) {
  Orbit orbit{.target = {1.0, 0.0, 0.0}, .distance = 1.0, .azimuth = M_PI, .elevation = 0.0, .field_of_view = M_PI / 2};
  return orbit.viewpoint(width, height);
}

TEST(SurfacePick, FindsTheTriangleUnderThePixelUpToTheWallsBorder) {
  // At depth 2 a pixel of 101 is 4 / 101 m wide: a wall of 3 m is seen from pixel 12.6 to 87.4.
  const auto mesh = wall(2.0F, 1.5F);
  for (const int width : {101, 64}) {
    const auto eye = along_x(width, 101);
    const double middle = 0.5 * (width - 1);
    const double edge = 1.5 / 2.0 * 101 / 2.0;
    for (const double sign : {-1.0, 1.0}) {
      if (edge < middle) {
        EXPECT_TRUE(pick(mesh, eye, {middle + sign * (edge - 0.01), 50.0}));
        EXPECT_FALSE(pick(mesh, eye, {middle + sign * (edge + 0.01), 50.0}));
      }
      EXPECT_TRUE(pick(mesh, eye, {middle, 50.0 + sign * (edge - 0.01)}));
      EXPECT_FALSE(pick(mesh, eye, {middle, 50.0 + sign * (edge + 0.01)}));
    }
    const auto below = pick(mesh, eye, {middle + 5.0, 60.0}), above = pick(mesh, eye, {middle - 5.0, 40.0});
    ASSERT_TRUE(below && above);
    EXPECT_EQ(below->triangle, 0U);  // the one without the upper left corner
    EXPECT_EQ(above->triangle, 1U);
    EXPECT_NEAR(below->depth, 2.0, 1e-6);
    EXPECT_NEAR(below->place.x(), 2.0, 1e-6);
    const auto seen = seen_at(eye, below->place);
    EXPECT_NEAR(seen->x(), middle + 5.0, 1e-6);
    EXPECT_NEAR(seen->y(), 60.0, 1e-6);
  }
}

TEST(SurfacePick, TakesTheFirstAndNothingBehindTheEye) {
  auto mesh = wall(3.0F, 1.0F);
  for (const float x : {2.0F, -1.0F}) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    const auto other = wall(x, 1.0F);
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const auto& t : other.triangles) mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
  const auto eye = along_x(80, 60);
  const auto found = pick(mesh, eye, {40.0, 20.0});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->depth, 2.0, 1e-6);
  EXPECT_TRUE(found->triangle == 2 || found->triangle == 3);
  EXPECT_FALSE(pick(wall(-1.0F, 1.0F), eye, {40.0, 30.0}));
  EXPECT_FALSE(seen_at(eye, Vector3d(-1.0, 0.0, 0.0)));
  EXPECT_FALSE(pick({}, eye, {40.0, 30.0}));
}

// The graphics driver as an independent witness: every triangle drawn in a colour of its own.
TEST(SurfacePick, AgreesWithWhatIsDrawn) {
  const auto body = tests::scan_of(tests::someone());
  recon::TriangleMesh painted;
  for (std::uint32_t t = 0; t < body.triangles.size(); ++t) {
    const auto base = static_cast<std::uint32_t>(painted.positions.size());
    for (const auto v : body.triangles[t]) {
      painted.positions.push_back(body.positions[v]);
      painted.normals.push_back(body.normals[v]);
      painted.colours.push_back({static_cast<std::uint8_t>(t & 255), static_cast<std::uint8_t>(t >> 8), 255});
    }
    painted.triangles.push_back({base, base + 1, base + 2});
  }
  const HeadlessDisplay display;
  const Orbit orbit{.target = {0.0, 0.0, 0.9}, .distance = 4.5, .azimuth = 0.7, .elevation = 0.3};
  for (const auto& [width, height] : {std::pair{333, 247}, std::pair{200, 300}}) {
    const auto eye = orbit.viewpoint(width, height);
    const auto drawn = render_mesh(painted, eye, {.cull = false});
    int surface = 0, unlike = 0;
    for (int y = 0; y < height; y += 3)
      for (int x = 0; x < width; x += 3) {
        const auto& pixel = drawn.at<cv::Vec4b>(y, x);
        const auto found = pick(body, eye, Vector2d(x, y));
        surface += pixel[3] > 0;
        if (pixel[3] == 0)
          unlike += found.has_value();
        else
          unlike += !found || found->triangle != pixel[0] + 256U * pixel[1];
      }
    EXPECT_GT(surface, 300);
    // Drivers draw from corners rounded to 1/256 pixel: of triangles some pixels wide that is a hundredth of their
    // pixels.
    EXPECT_LE(unlike, surface / 100);
  }
}

}  // namespace
}  // namespace rotunda::playback
