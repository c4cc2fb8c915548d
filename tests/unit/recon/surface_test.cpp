#include "recon/hull/surface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

std::vector<capture::CameraModel> small_rig() {
  simulator::LayoutOptions options;
  options.width = 160;
  options.height = 128;
  return simulator::camera_layout(options);
}

// Casting silhouettes takes longer than most tests: once for all.
const std::vector<capture::Matte>& person_mattes() {
  static const auto mattes = tests::mattes_of(tests::person(), small_rig());
  return mattes;
}

// In pixels of its own: zeros assigned to a matte's alpha would land in what all copies of person_mattes() share.
capture::Matte nobody() {
  return {cv::Mat(128, 160, CV_8UC1, cv::Scalar(0))};
}

SurfaceOptions stage() {
  SurfaceOptions options;
  options.bounds.emplace(Eigen::Vector3d(-1.5, -1.0, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0));
  options.cell_size = 0.03;
  return options;
}

TEST(Surface, OfAPersonIsOneClosedSphereNearTheTruth) {
  const auto cameras = small_rig();
  const auto body = tests::person();
  const auto result = reconstruct_surface(cameras, person_mattes(), stage());
  ASSERT_EQ(result.failure, "");
  EXPECT_TRUE(topology_of(result.mesh).is_sphere());
  EXPECT_EQ(result.mesh.normals.size(), result.mesh.positions.size());
  EXPECT_EQ(result.report.triangles, result.mesh.triangles.size());
  double sum = 0.0;
  for (const auto& p : result.mesh.positions) sum += std::abs(tests::signed_distance(body, p.cast<double>()));
  EXPECT_LT(sum / static_cast<double>(result.mesh.positions.size()), 0.025);  // cells of 30 mm, pixels of 18 mm
}

double share_of_edges_below(const TriangleMesh& mesh, double length) {
  std::size_t below = 0;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      if (static_cast<double>((mesh.positions[t[i]] - mesh.positions[t[(i + 1) % 3]]).norm()) < length) ++below;
  return static_cast<double>(below) / (3.0 * static_cast<double>(mesh.triangles.size()));
}

double mean_distance(const TriangleMesh& mesh, const tests::CapsuleBody& body) {
  double sum = 0.0;
  for (const auto& p : mesh.positions) sum += std::abs(tests::signed_distance(body, p.cast<double>()));
  return sum / static_cast<double>(mesh.positions.size());
}

TEST(Surface, DrawnInBetweenTheRimsIsNearerToTheBodyThanTheHull) {
  const auto cameras = small_rig();
  for (const bool hands_on_hips : {false, true}) {
    const auto body = tests::person(hands_on_hips);
    const auto mattes = hands_on_hips ? tests::mattes_of(body, cameras) : person_mattes();
    auto options = stage();
    const auto drawn_in = reconstruct_surface(cameras, mattes, options);
    options.fit_rims = false;
    const auto hull = reconstruct_surface(cameras, mattes, options);
    ASSERT_EQ(drawn_in.failure + hull.failure, "");
    EXPECT_GT(drawn_in.report.rims, 100U);
    EXPECT_LT(mean_distance(drawn_in.mesh, body), 0.9 * mean_distance(hull.mesh, body));
    EXPECT_TRUE(topology_of(drawn_in.mesh).is_sphere());
  }
}

// A hole in one camera's matte where an arm is.
TEST(Surface, KeepsAnArmThatOneMatteHasLostAndTellsWhichWhereMissesAreTolerated) {
  const auto cameras = small_rig();
  auto mattes = person_mattes();
  const auto hand = capture::project(cameras[2], {0.1, 0.60, 1.0});
  mattes[2].alpha = mattes[2].alpha.clone();
  cv::Mat lost = mattes[2].alpha(cv::Rect(static_cast<int>(hand->x()) - 6, static_cast<int>(hand->y()) - 6, 12, 12));
  lost.setTo(0);
  auto options = stage();
  options.tolerate_misses = 1;
  const auto result = reconstruct_surface(cameras, mattes, options);
  ASSERT_EQ(result.failure, "");
  float farthest = 0.0F;
  for (const auto& p : result.mesh.positions) farthest = std::max(farthest, p.y());
  EXPECT_GT(farthest, 0.58F);
  ASSERT_FALSE(result.report.denied.empty());
  const auto most = std::max_element(result.report.denied.begin(), result.report.denied.end(),
                                     [](const auto& a, const auto& b) { return a.share < b.share; });
  EXPECT_EQ(most->camera, cameras[2].name);
  EXPECT_LT(most->share, 0.1);
}

TEST(Surface, AtLiveQualityHasCoarserCellsAndNoSlivers) {
  const auto cameras = small_rig();
  auto options = stage();
  options.cell_size = 0.015;
  const auto live = reconstruct_surface(cameras, person_mattes(), live_surface(options));
  ASSERT_EQ(live.failure, "");
  EXPECT_TRUE(topology_of(live.mesh).is_sphere());
  EXPECT_GT(live.report.cell_size, 1.3 * options.cell_size);
  EXPECT_GT(live.report.triangles, live.report.extracted_triangles * 8 / 10);
  EXPECT_LT(share_of_edges_below(live.mesh, 0.2 * live.report.cell_size), 0.01);  // those whose collapse would fold
}

TEST(Surface, WithHandsOnHipsIsCutToASphere) {
  const auto cameras = small_rig();
  const auto result = reconstruct_surface(cameras, tests::mattes_of(tests::person(true), cameras), stage());
  ASSERT_EQ(result.failure, "");
  EXPECT_TRUE(topology_of(result.mesh).is_sphere());
  EXPECT_GT(result.report.cut.cut_voxels, 0U);
}

// A person, a larger one beside them, a ball of 14 litres and a marble.
tests::CapsuleBody two_people_and_balls() {
  tests::CapsuleBody all;
  for (auto part : tests::person())
    all.push_back({part.a + Eigen::Vector3d(0.8, 0, 0), part.b + Eigen::Vector3d(0.8, 0, 0), part.radius});
  for (auto part : tests::person())
    all.push_back(
        {1.1 * part.a + Eigen::Vector3d(-0.6, 0, 0), 1.1 * part.b + Eigen::Vector3d(-0.6, 0, 0), 1.1 * part.radius});
  all.push_back({{0.1, -0.7, 0.6}, {0.1, -0.7, 0.6}, 0.15});
  all.push_back({{0.1, 0.7, 0.9}, {0.1, 0.7, 0.9}, 0.05});
  return all;
}

Eigen::AlignedBox3f box_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const auto& position : mesh.positions) box.extend(position);
  return box;
}

TEST(Surface, IsOfTheLargestPieceOrOfThePerformerAskedForOrOfAllOnThreads) {
  const auto cameras = small_rig();
  const auto mattes = tests::mattes_of(two_people_and_balls(), cameras);
  auto options = stage();
  const auto largest = reconstruct_surface(cameras, mattes, options);
  ASSERT_EQ(largest.failure, "");
  EXPECT_LT(box_of(largest.mesh).max().x(), 0.1F);
  EXPECT_GE(largest.report.cut.pieces.pieces, 4U);  // silhouettes of several leave phantoms, too
  options.performer_at.emplace(1.0, 0.3);
  const auto asked = reconstruct_surface(cameras, mattes, options);
  ASSERT_EQ(asked.failure, "");
  EXPECT_GT(box_of(asked.mesh).min().x(), 0.4F);
  options.tied_litres = 5.0;
  const auto all = reconstruct_surface(cameras, mattes, options);
  ASSERT_EQ(all.failure, "");
  EXPECT_TRUE(topology_of(all.mesh).is_sphere());
  EXPECT_EQ(all.report.cut.pieces.tied, 2U);
  EXPECT_GT(all.report.cut.pieces.dropped_voxels, 0U) << "the marble";
  EXPECT_LT(box_of(all.mesh).min().x(), -0.6F);
  EXPECT_LT(box_of(all.mesh).min().y(), -0.8F);
  EXPECT_NEAR(all.report.volume, largest.report.volume + asked.report.volume + 0.014, 0.008) << "threads are thin";
}

TEST(Surface, HasNoMoreTrianglesThanAsked) {
  const auto cameras = small_rig();
  auto options = stage();
  options.triangles = 800;
  const auto result = reconstruct_surface(cameras, person_mattes(), options);
  EXPECT_LE(result.mesh.triangles.size(), 800U);
  EXPECT_GE(result.mesh.triangles.size(), 700U);
  EXPECT_TRUE(topology_of(result.mesh).is_sphere());
}

TEST(Surface, FindsTheVolumeItself) {
  const auto cameras = small_rig();
  auto options = stage();
  options.bounds.reset();
  const auto result = reconstruct_surface(cameras, person_mattes(), options);
  EXPECT_EQ(result.failure, "");
  EXPECT_TRUE(topology_of(result.mesh).is_sphere());
}

TEST(Surface, NamesTheCameraWithAnEmptySilhouette) {
  const auto cameras = small_rig();
  auto mattes = person_mattes();
  mattes[3] = nobody();
  const auto result = reconstruct_surface(cameras, mattes, stage());
  EXPECT_EQ(result.failure, "empty silhouette in cam03");
  EXPECT_TRUE(result.mesh.triangles.empty());
}

TEST(Surface, NeedsNothingOfACameraThatLooksElsewhere) {
  auto cameras = small_rig();
  auto mattes = person_mattes();
  const auto alone = reconstruct_surface(cameras, mattes, stage());
  cameras.push_back(simulator::look_at({3.6, 0.0, 1.3}, {9.0, 0.0, 1.3}, 160, 128, 200.0, 200.0));
  cameras.back().name = "away";
  mattes.push_back(nobody());
  const auto result = reconstruct_surface(cameras, mattes, stage());
  ASSERT_EQ(result.failure, "");
  EXPECT_EQ(result.mesh.positions, alone.mesh.positions);
}

TEST(Surface, NamesAllCamerasWhereTooFewSeeAnybody) {
  const std::vector<capture::CameraModel> cameras = small_rig();
  auto mattes = person_mattes();
  std::fill(mattes.begin() + 1, mattes.end(), nobody());
  const auto result = reconstruct_surface(cameras, mattes, stage());
  EXPECT_EQ(result.failure.find("empty silhouette in cam01, cam02"), 0U) << result.failure;
}

TEST(Surface, TellsOfCellsThatDoNotFitIntoTheVolume) {
  auto options = stage();
  options.cell_size = 20.0;  // millimetres meant, in a world of metres
  const auto result = reconstruct_surface(small_rig(), person_mattes(), options);
  EXPECT_NE(result.failure.find("cells of 20 do not fit into the volume, 3 x 2 x 2"), std::string::npos)
      << result.failure;
}

TEST(Surface, TellsOfAnEmptyHull) {
  const auto cameras = small_rig();
  auto mattes = tests::mattes_of(tests::ball({0.4, 0, 1}, 0.1), cameras);
  for (std::size_t i = 0; i < 3; ++i) mattes[i] = tests::matte_of(tests::ball({-0.4, 0, 1.4}, 0.1), cameras[i]);
  EXPECT_NE(reconstruct_surface(cameras, mattes, stage()).failure.find("empty hull"), std::string::npos);
}

TEST(Surface, TellsWhereThePerformerIsIfNotInTheVolume) {
  auto options = stage();
  options.bounds.emplace(Eigen::Vector3d(0.9, 0.5, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0));
  const auto failure = reconstruct_surface(small_rig(), person_mattes(), options).failure;
  EXPECT_NE(failure.find("which meet between (-"), std::string::npos) << failure;
}

TEST(Surface, TellsOfSilhouettesThatFillAllPictures) {
  const capture::Matte full{cv::Mat(128, 160, CV_8UC1, cv::Scalar(255))};
  const std::vector<capture::Matte> mattes(10, full);
  EXPECT_NE(reconstruct_surface(small_rig(), mattes, stage()).failure.find("found no backdrop"), std::string::npos);
}

TEST(Surface, SurvivesACameraWhoseCalibrationIsTwoDegreesOff) {
  auto cameras = small_rig();
  const Eigen::AngleAxisd off(0.035, Eigen::Vector3d::UnitY());
  cameras[3].R = off * cameras[3].R;
  cameras[3].t = off * cameras[3].t;
  const auto result = reconstruct_surface(cameras, person_mattes(), stage());
  EXPECT_EQ(result.failure, "");
  EXPECT_TRUE(result.report.topology.is_sphere());
}

TEST(Surface, RefusesMattesThatDoNotMatchTheCameras) {
  const auto cameras = small_rig();
  EXPECT_THROW(reconstruct_surface(cameras, {}, stage()), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
