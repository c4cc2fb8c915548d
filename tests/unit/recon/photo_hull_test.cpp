#include "recon/hull/photo_hull.h"

#include <gtest/gtest.h>

#include "config/errors.h"
#include "recon/hull/visual_hull.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/painted_ball.h"

namespace rotunda::recon {
namespace {

struct Scene {
  tests::PaintedBall ball{{0.0, 0.0, 0.95}, 0.25, {0.30, 0.0, 0.95}, 0.16, 0.4};  // a dent towards the first camera
  std::vector<capture::CameraModel> cameras =
      simulator::camera_layout({.width = 240, .height = 192, .subject_height = 0.8});
  std::vector<cv::Mat> pictures;
  std::vector<capture::Matte> mattes;
  Scene() {
    for (const auto& camera : cameras) {
      const auto view = tests::view_of(ball, camera);
      pictures.push_back(view.rgb);
      mattes.push_back(view.matte);
    }
  }
};

struct Volumes {
  double wrong = 0.0, missing = 0.0;  // litres inside where the body is not, and the other way
};

Volumes compare(const SignedGrid& grid, const tests::PaintedBall& ball) {
  const double litres = 1e3 * std::pow(grid.cell_size(), 3.0);
  Volumes volumes;
  for (VoxelId id = 0; id < grid.voxel_count(); ++id) {
    const double truth = tests::signed_distance(ball, grid.position(id));
    if (grid.value(id) > 0.0F && truth < 0.0) volumes.wrong += litres;
    if (grid.value(id) <= 0.0F && truth > grid.cell_size()) volumes.missing += litres;
  }
  return volumes;
}

TEST(PhotoHull, CarvesADentThatNoSilhouetteShows) {
  const Scene scene;
  const auto views = silhouette_views(scene.cameras, scene.mattes);
  auto grid = visual_hull(
      views, {.bounds = {Eigen::Vector3d(-0.4, -0.4, 0.5), Eigen::Vector3d(0.4, 0.4, 1.4)}, .cell_size = 0.012});
  const auto before = compare(grid, scene.ball);
  const auto report = carve_photo_hull(grid, views, scene.pictures, {.deepest = 0.15});
  const auto after = compare(grid, scene.ball);
  EXPECT_GT(report.carved, 0U);
  EXPECT_GT(report.rounds, 1);
  EXPECT_LT(after.wrong, 0.7 * before.wrong);
  EXPECT_LT(after.missing, 0.1 * (before.wrong - after.wrong));
}

TEST(PhotoHull, CarvesNothingOfOneColour) {
  Scene scene;
  for (auto& picture : scene.pictures) picture.setTo(cv::Scalar(90, 120, 60));
  const auto views = silhouette_views(scene.cameras, scene.mattes);
  auto grid = visual_hull(
      views, {.bounds = {Eigen::Vector3d(-0.4, -0.4, 0.5), Eigen::Vector3d(0.4, 0.4, 1.4)}, .cell_size = 0.02});
  EXPECT_EQ(carve_photo_hull(grid, views, scene.pictures).carved, 0U);
}

TEST(PhotoHull, RefusesPicturesThatDoNotFit) {
  const Scene scene;
  const auto views = silhouette_views(scene.cameras, scene.mattes);
  SignedGrid grid;
  EXPECT_THROW(carve_photo_hull(grid, views, {}), InvalidInput);
  auto small = scene.pictures;
  small[2] = small[2](cv::Rect(0, 0, 10, 10)).clone();
  EXPECT_THROW(carve_photo_hull(grid, views, small), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
