#pragma once
// A painted ball before the studio's cameras, and meshes beside its surface: for what compares pictures.
#include <vector>

#include "recon/hull/marching_cubes.h"
#include "recon/hull/visual_hull.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/painted_ball.h"

namespace rotunda::tests {

inline constexpr double kBallCell = 0.012;

struct PaintedBallScene {
  std::vector<capture::CameraModel> cameras =
      simulator::camera_layout({.width = 360, .height = 288, .subject_height = 1.0});
  std::vector<cv::Mat> pictures;
  explicit PaintedBallScene(const PaintedBall& ball) {
    for (const auto& camera : cameras) pictures.push_back(view_of(ball, camera).rgb);
  }
};

// A closed mesh whose vertices lie `beside` the ball's surface, with normals.
inline recon::TriangleMesh ball_mesh(const PaintedBall& ball, double beside) {
  std::vector<Eigen::Vector3i> blocks;
  for (int i = 0; i < 512; ++i) blocks.emplace_back(i % 8, i / 8 % 8, i / 64);
  recon::SignedGrid grid(ball.centre - Eigen::Vector3d::Constant(32.0 * kBallCell), kBallCell, -0.1F, blocks);
  for (recon::VoxelId id = 0; id < grid.voxel_count(); ++id)
    grid.set_value(id, static_cast<float>(ball.radius - (grid.position(id) - ball.centre).norm()));
  auto mesh = recon::marching_cubes(grid);
  for (auto& position : mesh.positions)
    position =
        (ball.centre + (ball.radius + beside) * (position.cast<double>() - ball.centre).normalized()).cast<float>();
  recon::compute_normals(mesh);
  return mesh;
}

}  // namespace rotunda::tests
