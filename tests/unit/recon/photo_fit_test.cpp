#include "recon/hull/photo_fit.h"

#include <gtest/gtest.h>

#include "recon/hull/marching_cubes.h"
#include "recon/hull/visual_hull.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/painted_ball.h"

namespace rotunda::recon {
namespace {

// A closed mesh whose vertices lie `beside` the ball's surface.
TriangleMesh ball_mesh(const tests::PaintedBall& ball, double beside) {
  std::vector<Eigen::Vector3i> blocks;
  for (int i = 0; i < 512; ++i) blocks.emplace_back(i % 8, i / 8 % 8, i / 64);
  constexpr double kCell = 0.012;
  SignedGrid grid(ball.centre - Eigen::Vector3d::Constant(32.0 * kCell), kCell, -0.1F, blocks);
  for (VoxelId id = 0; id < grid.voxel_count(); ++id)
    grid.set_value(id, static_cast<float>(ball.radius - (grid.position(id) - ball.centre).norm()));
  auto mesh = marching_cubes(grid);
  for (auto& position : mesh.positions)
    position =
        (ball.centre + (ball.radius + beside) * (position.cast<double>() - ball.centre).normalized()).cast<float>();
  compute_normals(mesh);
  return mesh;
}

struct Scene {
  std::vector<capture::CameraModel> cameras =
      simulator::camera_layout({.width = 360, .height = 288, .subject_height = 1.0});
  std::vector<cv::Mat> pictures;
  explicit Scene(const tests::PaintedBall& ball) {
    for (const auto& camera : cameras) pictures.push_back(tests::view_of(ball, camera).rgb);
  }
};

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
  const Scene scene(ball);
  for (const double beside : {0.006, -0.004}) {
    const auto mesh = ball_mesh(ball, beside);
    const std::vector<float> far_from_rims(mesh.positions.size(), 0.1F);
    const auto views = photo_views(mesh, scene.cameras, scene.pictures);
    EXPECT_NEAR(mean_offset(mesh, photo_offsets(mesh, far_from_rims, views, {})), -beside, 0.002);  // pixels of 3.5 mm
  }
}

TEST(PhotoFit, StaysWhereItIsWithoutPicturesOfIt) {
  const tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25};
  const auto mesh = ball_mesh(ball, 0.006);
  const std::vector<float> distance(mesh.positions.size(), 0.1F);
  for (const float offset : photo_offsets(mesh, distance, {}, {})) ASSERT_NEAR(offset, 0.0F, 1e-6F);
}

}  // namespace
}  // namespace rotunda::recon
