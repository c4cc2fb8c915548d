#include "recon/hull/photo_fit.h"

#include <gtest/gtest.h>

#include "recon/mesh/vertex_rings.h"
#include "tests/support/painted_ball_scene.h"

namespace rotunda::recon {
namespace {

using tests::ball_mesh;
using tests::PaintedBallScene;

double mean_offset(const TriangleMesh& mesh, const std::vector<float>& offsets) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < offsets.size(); ++v) {
    if (mesh.normals[v].z() < -0.3F) continue;  // no camera looks from below
    sum += static_cast<double>(offsets[v]);
    ++count;
  }
  return sum / count;
}

TEST(PhotoFit, FindsWhereThePicturesAgree) {
  tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  ball.detail = 4.0;
  const PaintedBallScene scene(ball);
  for (const double beside : {0.006, -0.004}) {
    const auto mesh = ball_mesh(ball, beside);
    const std::vector<float> far_from_rims(mesh.positions.size(), 0.1F);
    const auto views = photo_views(mesh, scene.cameras, scene.pictures);
    EXPECT_NEAR(mean_offset(mesh, photo_offsets(mesh, far_from_rims, views, {})), -beside, 0.002);  // pixels of 3.5 mm
  }
}

// Of pictures that hardly tell (a sixteenth of their usual weight): beside a rim the silhouette knows better, two
// centimetres from it they win more than half of the way.
TEST(PhotoFit, GivesWayToPicturesTheFartherFromRims) {
  tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  ball.detail = 4.0;
  const PaintedBallScene scene(ball);
  const auto mesh = ball_mesh(ball, 0.012);
  const auto views = photo_views(mesh, scene.cameras, scene.pictures);
  const auto mean_at = [&](float rim_distance) {
    const std::vector<float> distance(mesh.positions.size(), rim_distance);
    return mean_offset(mesh, photo_offsets(mesh, distance, views, {.photo_weight = 2.0}));
  };
  const double near = mean_at(0.02F);
  EXPECT_GT(mean_at(0.0F), -0.004);
  EXPECT_LT(near, -0.006);
  EXPECT_LT(mean_at(0.1F), near);
}

TEST(PhotoFit, StaysWhereItIsWithoutPicturesOfIt) {
  const tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  const auto mesh = ball_mesh(ball, 0.006);
  const std::vector<float> distance(mesh.positions.size(), 0.1F);
  for (const float offset : photo_offsets(mesh, distance, {}, {})) ASSERT_NEAR(offset, 0.0F, 1e-6F);
}

TEST(PhotoFit, TakesNoStepBetweenNeighboursThatIsSteeperThanAllowed) {
  const tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  PaintedBallScene scene(ball);
  cv::RNG random(1);  // pictures that agree here and there by chance
  for (auto& picture : scene.pictures) random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  const auto mesh = ball_mesh(ball, 0.0);
  const std::vector<float> distance(mesh.positions.size(), 0.1F);
  const PhotoFitOptions options{.reach = 0.032, .smoothness = 0.01, .steepest = 0.25};
  const auto offsets = photo_offsets(mesh, distance, photo_views(mesh, scene.cameras, scene.pictures), options);
  EXPECT_GT(*std::max_element(offsets.begin(), offsets.end()), 1e-3F);
  const VertexRings rings(mesh);
  for (std::size_t v = 0; v < offsets.size(); ++v)
    for (const auto n : rings[v])
      ASSERT_LE(std::abs(offsets[v] - offsets[n]), 0.251F * (mesh.positions[v] - mesh.positions[n]).norm());
}

}  // namespace
}  // namespace rotunda::recon
