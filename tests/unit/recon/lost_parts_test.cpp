#include "recon/hull/lost_parts.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "recon/hull/surface.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

using testing::Each;

constexpr std::size_t kFailing = 2;  // the camera whose key fails
const Eigen::AlignedBox3d kVolume(Eigen::Vector3d(-1.5, -1.0, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0));
const LostPartsOptions kOptions{kVolume, 0.04};
const Eigen::Vector3d kKnee(0.03, 0.13, 0.5), kFoot(0.0, 0.15, 0.06);  // of the person of capsules

std::vector<capture::CameraModel> small_rig() {
  return simulator::camera_layout({.width = 240, .height = 192});
}

std::vector<capture::Matte> person_mattes() {
  return tests::mattes_of(tests::person(), small_rig());
}

// The lower leg, as where the trousers are as dark as the floor.
void lose_leg(capture::Matte& matte, const capture::CameraModel& camera) {
  const auto knee = capture::project(camera, kKnee), foot = capture::project(camera, kFoot);
  matte.alpha = matte.alpha.clone();
  cv::line(matte.alpha, cv::Point2d(knee->x(), knee->y()), cv::Point2d(foot->x(), foot->y()), 0, 15);
}

double height_of_feet(const TriangleMesh& mesh) {
  double lowest = 1e9;
  for (const auto& p : mesh.positions)
    if (p.y() > 0.05F) lowest = std::min(lowest, static_cast<double>(p.z()));
  return lowest;
}

TEST(LostParts, NothingIsPutBackWhereAllMattesAreRight) {
  const auto views = silhouette_views(small_rig(), person_mattes());
  EXPECT_THAT(put_back_lost_parts(views, kOptions).share, Each(0.0));
}

TEST(LostParts, ALegThatOneKeyLostIsPutBackIntoThatViewAlone) {
  const auto cameras = small_rig();
  auto mattes = person_mattes();
  lose_leg(mattes[kFailing], cameras[kFailing]);
  const auto views = silhouette_views(cameras, mattes);
  ASSERT_LT(*views[kFailing].distance(0.5 * (kKnee + kFoot)), 0.0F);
  const auto back = put_back_lost_parts(views, kOptions);
  for (std::size_t i = 0; i < views.size(); ++i) EXPECT_EQ(back.share[i] > 0.0, i == kFailing) << cameras[i].name;
  EXPECT_GT(back.share[kFailing], 0.05);
  EXPECT_LT(back.share[kFailing], 0.4);
  EXPECT_GT(*back.views[kFailing].distance(0.5 * (kKnee + kFoot)), 0.0F);
  EXPECT_EQ(*back.views[kFailing].distance({0.0, 0.0, 1.2}), *views[kFailing].distance({0.0, 0.0, 1.2}));
}

TEST(LostParts, TwoKeysMayLoseTheSame) {
  const auto cameras = small_rig();
  auto mattes = person_mattes();
  for (const std::size_t i : {kFailing, kFailing + 3}) lose_leg(mattes[i], cameras[i]);
  const auto back = put_back_lost_parts(silhouette_views(cameras, mattes), kOptions);
  for (const std::size_t i : {kFailing, kFailing + 3})
    EXPECT_GT(*back.views[i].distance(0.5 * (kKnee + kFoot)), 0.0F) << cameras[i].name;
}

TEST(LostParts, OfFourViewsNoneIsOutvoted) {
  auto cameras = small_rig();
  auto mattes = person_mattes();
  lose_leg(mattes[kFailing], cameras[kFailing]);
  cameras.resize(4);
  mattes.resize(4);
  EXPECT_THAT(put_back_lost_parts(silhouette_views(cameras, mattes), kOptions).share, Each(0.0));
}

TEST(LostParts, TheSurfaceKeepsTheLegAndTellsWhoseKeyFailed) {
  const auto cameras = small_rig();
  auto mattes = person_mattes();
  lose_leg(mattes[kFailing], cameras[kFailing]);
  SurfaceOptions options{.bounds = kVolume, .cell_size = 0.03};
  const auto kept = reconstruct_surface(cameras, mattes, options);
  options.put_back_lost = false;
  const auto cut = reconstruct_surface(cameras, mattes, options);
  ASSERT_EQ(kept.failure + cut.failure, "");
  EXPECT_LT(height_of_feet(kept.mesh), 0.05);
  EXPECT_GT(height_of_feet(cut.mesh), 0.3);
  ASSERT_EQ(kept.report.put_back.size(), 1U);
  EXPECT_EQ(kept.report.put_back.front().camera, cameras[kFailing].name);
  EXPECT_TRUE(cut.report.put_back.empty());
}

}  // namespace
}  // namespace rotunda::recon
