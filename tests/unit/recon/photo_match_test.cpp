#include "recon/hull/photo_match.h"

#include <gtest/gtest.h>

#include "tests/support/painted_ball_scene.h"

namespace rotunda::recon {
namespace {

// Of a surface without rims, moved to where the pictures agree.
TriangleMesh matched(const TriangleMesh& mesh, const tests::PaintedBallScene& scene) {
  auto moved = mesh;
  match_to_pictures(moved, {scene.cameras, scene.pictures, {}, mesh, rim_fit_options(tests::kBallCell, 1.0, 1)});
  return moved;
}

// Means over what the cameras see; none looks from below.
double mean_beside(const TriangleMesh& mesh, const tests::PaintedBall& ball) {
  double sum = 0.0;
  int count = 0;
  for (const auto& position : mesh.positions) {
    const Eigen::Vector3d from_centre = position.cast<double>() - ball.centre;
    if (from_centre.z() < -0.3 * ball.radius) continue;
    sum += std::abs(from_centre.norm() - ball.radius);
    ++count;
  }
  return sum / count;
}

TEST(PhotoMatch, BringsASurfaceFromOutsideToThePaintedBall) {
  tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  ball.detail = 2.0;
  const auto mesh = tests::ball_mesh(ball, 0.012);
  EXPECT_LT(mean_beside(matched(mesh, tests::PaintedBallScene(ball)), ball), 0.004);  // pixels of 3.5 mm
}

TEST(PhotoMatch, OfNoiseMovesASurfaceByLessThanAPixel) {
  const tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  tests::PaintedBallScene scene(ball);
  cv::RNG random(1);
  for (auto& picture : scene.pictures) random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  const auto mesh = tests::ball_mesh(ball, 0.0);
  EXPECT_LT(mean_beside(matched(mesh, scene), ball), 0.0035);
}

// Waves of 24 mm: with two cameras 45 degrees apart the same again 29 mm deeper.
TEST(PhotoMatch, IsNotLedAstrayByAPatternThatRepeats) {
  tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  ball.repeat = 0.024;
  const tests::PaintedBallScene scene(ball);
  for (const double beside : {0.0, 0.010}) {
    const auto mesh = tests::ball_mesh(ball, beside);
    EXPECT_LT(mean_beside(matched(mesh, scene), ball), std::max(0.0015, beside)) << beside;
  }
}

// A patch that is the same again 29 mm deeper, where all around it tells that it lies deeper.
TEST(PhotoMatch, LeavesNoLumpWhereAPatternRepeatsAmidOneThatDoesNot) {
  tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  ball.detail = 2.0;
  ball.repeat = 0.024;
  ball.repeat_at = ball.centre + ball.radius * Eigen::Vector3d(std::cos(0.4), std::sin(0.4), 0.0);
  ball.repeat_radius = 0.10;
  const auto mesh = matched(tests::ball_mesh(ball, 0.029), tests::PaintedBallScene(ball));
  double farthest = 0.0;
  for (const auto& position : mesh.positions) {
    const Eigen::Vector3d from_centre = position.cast<double>() - ball.centre;
    const Eigen::Vector3d below = ball.centre + ball.radius * from_centre.normalized();
    if ((below - ball.repeat_at).norm() < ball.repeat_radius)
      farthest = std::max(farthest, std::abs(from_centre.norm() - ball.radius));
  }
  EXPECT_LT(farthest, 0.0035);  // a pixel
}

}  // namespace
}  // namespace rotunda::recon
