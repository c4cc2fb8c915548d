#include "recon/deform/scan_animation.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <fstream>

#include "config/errors.h"
#include "recon/export/animation_export.h"
#include "tests/support/template_person.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::HasSubstr;
using enum BodyJoint;
using tests::bvh_text_with;
using tests::kDegree;
using tests::scan_of;
using tests::someone;

BodyMotion motion() {
  return import_bvh(parse_bvh(bvh_text_with(90.0, 20.0)));
}

std::string refusal(const auto& work) {
  try {
    work();
  } catch (const InvalidInput& error) {
    return error.what();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "taken";
}

TEST(BodyMotion, TakesAnyonesBvhForTurnsOfOurJointsAndAPathInMetres) {
  const auto moved = motion();
  ASSERT_EQ(moved.poses.size(), 3U);
  EXPECT_NEAR(moved.leg_length, 0.82, 1e-9);
  const auto body = template_of_height(1.8);
  const auto poses = poses_for(moved, body.skeleton);
  const auto bent = joint_positions(body.skeleton, poses[1]);
  const Vector3d upper = bent[index(forearm_left)] - bent[index(upper_arm_left)],
                 fore = bent[index(hand_left)] - bent[index(forearm_left)];
  EXPECT_GT(upper.normalized().y(), 0.999);  // to the left
  EXPECT_GT(fore.normalized().x(), 0.999);   // forwards
  EXPECT_GT((bent[index(hand_right)] - bent[index(forearm_right)]).normalized().dot(-Vector3d::UnitY()), 0.999);
  // 20 cm of legs of 82 cm.
  EXPECT_NEAR((poses[2].root - poses[1].root).y(), 0.2 * body.skeleton.leg_length() / 0.82, 1e-6);
}

TEST(BodyMotion, RefusesRadians) {
  EXPECT_THAT(refusal([] { import_bvh(parse_bvh(bvh_text_with(1.5708, 20.0))); }), HasSubstr("look like radians"));
  EXPECT_NO_THROW(import_bvh(parse_bvh(bvh_text_with(1.5708, 20.0)), {.name = "still.bvh", .trust_angles = true}));
}

TEST(ScanPreparation, StandsAScanUpWhicheverWayItLies) {
  const auto upright = scan_of(someone());
  const auto prepared = prepare_scan(upright);
  for (const auto& turn : {Quaterniond(AngleAxisd(90 * kDegree, Vector3d::UnitX())),
                           Quaterniond(AngleAxisd(180 * kDegree, Vector3d::UnitX())),
                           Quaterniond(AngleAxisd(90 * kDegree, Vector3d::UnitY())),
                           Quaterniond(AngleAxisd(155 * kDegree, Vector3d::UnitZ()))}) {
    auto lying = upright;
    for (auto& p : lying.positions) p = (100.0 * (turn * p.cast<double>())).cast<float>();  // and in centimetres
    const auto stood = prepare_scan(lying);
    EXPECT_NEAR(stood.height, prepared.height, 1e-3);
    float worst = 0.0F;
    for (std::size_t v = 0; v < stood.mesh.positions.size(); ++v)
      worst = std::max(worst, (stood.mesh.positions[v] - prepared.mesh.positions[v]).norm());
    EXPECT_LT(worst, 0.01F);  // which way is forward is told to a degree
  }
}

TEST(ScanPreparation, RefusesWhatIsNoPersonInAPoseToAnimate) {
  auto hanging = someone();
  for (const auto arm : {upper_arm_left, upper_arm_right})
    hanging.pose.rotation[index(arm)] =
        Quaterniond(AngleAxisd((arm == upper_arm_left ? -88 : 88) * kDegree, Vector3d::UnitX()));
  EXPECT_THAT(refusal([&] { prepare_scan(scan_of(hanging)); }), HasSubstr("arms lie at its body"));
  auto two = scan_of(someone());
  const auto one = two;
  for (const auto& t : one.triangles) {
    const auto base = static_cast<std::uint32_t>(one.positions.size());
    two.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
  for (const auto& p : one.positions) two.positions.push_back(p + Vector3f(2.0F, 0.0F, 0.0F));
  two.normals.clear();
  EXPECT_NE(refusal([&] { prepare_scan(two); }), "taken");
  EXPECT_THAT(refusal([] { prepare_scan({}); }), HasSubstr("no triangles"));
  auto broken = one;
  broken.positions[5].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal([&] { prepare_scan(broken); }), HasSubstr("nowhere"));
}

class ScanAnimationTest : public testing::Test {
 protected:
  ScanAnimationTest() {
    fs::create_directories(folder_);
    scan_ = prepare_scan(scan_of(someone()));
    markers_ = propose_markers(scan_.mesh, scan_.from_triangle, fit_template(scan_.mesh));
  }
  ~ScanAnimationTest() override { fs::remove_all(folder_); }
  fs::path folder_ = fs::temp_directory_path() / ("rotunda_scan_animation_" + std::to_string(::getpid()));
  PreparedScan scan_;
  Markers markers_;
};

TEST_F(ScanAnimationTest, FindsTheBodyInTheScanAndMovesItAsItsSegmentsWould) {
  const auto truth = someone();
  const auto at = joint_positions(truth.body.skeleton, truth.pose);
  const auto found = joint_positions(markers_.fit->body.skeleton, markers_.fit->pose);
  for (const auto joint : {forearm_left, hand_left, shank_left, foot_left, forearm_right, shank_right, thigh_left})
    EXPECT_LT((found[index(joint)] - scan_.prepared_from_scan * at[index(joint)]).norm(), 0.03) << to_string(joint);
  ScanAnimation animation(scan_, markers_);
  const auto poses = animation.handle_poses(motion());
  std::vector<Vector3f> positions(3 * scan_.mesh.positions.size());
  animation.deform(poses, positions);
  EXPECT_LT(animation.drift(poses, positions), 1e-4);
  // The template is rigid within its segments: in the elbow's right angle the scan must be the posed template.
  auto moved = truth;
  const auto target = poses_for(motion(), truth.body.skeleton)[1];
  moved.pose = target;
  const auto wanted = pose_template(moved.body, moved.pose);
  const std::size_t n = vertices_of_segment(), forearm = 5 * n;
  const auto upright = scan_of(truth);
  const auto place = [&](std::size_t vertex) {  // preparing has put the vertices in another order
    const Vector3f at_rest = (scan_.prepared_from_scan * upright.positions[vertex].cast<double>()).cast<float>();
    const auto nearest = std::min_element(
        scan_.mesh.positions.begin(), scan_.mesh.positions.end(),
        [&](const auto& a, const auto& b) { return (a - at_rest).squaredNorm() < (b - at_rest).squaredNorm(); });
    return positions[scan_.mesh.positions.size() + static_cast<std::size_t>(nearest - scan_.mesh.positions.begin())];
  };
  double square = 0.0;
  for (std::size_t i = 0; i < n; ++i) {  // of the left forearm, from a vertex of the pelvis
    const Vector3f off = place(forearm + i) - place(0) - (wanted.positions[forearm + i] - wanted.positions[0]);
    square += static_cast<double>(off.squaredNorm());
  }
  EXPECT_LT(std::sqrt(square / static_cast<double>(n)), 0.04);  // joints found within 30 mm, a reach of two of them
}

// A scan whose legs are another's still has its joints where the performer's were.
TEST_F(ScanAnimationTest, StandsInTheStudioWhereThePerformerDid) {
  CapturedMotion captured{.body = template_of_height(1.62), .frames = {}};
  auto pose = markers_.fit->pose;
  pose.root = {0.7, -0.4, 0.83};
  pose.rotation[index(BodyJoint::pelvis)] = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ());
  captured.frames.push_back({.fit = {.pose = pose}});
  const ScanAnimation animation(scan_, markers_);
  const auto handles = animation.handle_poses_in_studio(captured);
  ASSERT_EQ(handles.size(), kBodySegments);
  const auto at_scan = joint_positions(animation.fit().body.skeleton, animation.fit().pose);
  const auto at_performer = joint_positions(captured.body.skeleton, pose);
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    const auto joint = index(joint_of_segment(s));
    const Vector3f carried = handles[s].rotation * at_scan[joint].cast<float>() + handles[s].translation;
    EXPECT_LT((carried - at_performer[joint].cast<float>()).norm(), 1e-4F) << segment_name(s);
  }
}

TEST_F(ScanAnimationTest, KeepsMarkersInAFileForPeople) {
  write_markers(folder_ / "markers.yaml", markers_, "scan.ply");
  const auto read = read_markers(folder_ / "markers.yaml");
  ASSERT_EQ(read.pairs.size(), markers_.pairs.size());
  EXPECT_EQ(read.pairs[7].scan_triangle, markers_.pairs[7].scan_triangle);
  ASSERT_TRUE(read.fit);
  EXPECT_LT((read.fit->pose.root - markers_.fit->pose.root).norm(), 1e-3);
  std::ofstream(folder_ / "bad.yaml") << "radius_mm: -4\nmarkers:\n"
                                         "  - {number: 1, segment: pelvis, template: 3, scan: 10}\n"
                                         "  - {number: 1, segment: head, template: 9999999, scan: 11}\n"
                                         "  - {number: 3, segment: hand_left, template: 600, scan: 10}\n"
                                         "  - {numbr: 4, template: 3, scan: 12}\n";
  const auto told = refusal([&] { read_markers(folder_ / "bad.yaml"); });
  EXPECT_THAT(told, HasSubstr("radius_mm"));
  EXPECT_THAT(told, HasSubstr("a number that no other marker has"));
  EXPECT_THAT(told, HasSubstr("a triangle of the template"));
  EXPECT_THAT(told, HasSubstr("the pelvis has it already"));
  EXPECT_THAT(told, HasSubstr("numbr"));
}

TEST_F(ScanAnimationTest, TellsMarkersThatDoNotFitTheScan) {
  auto missing = markers_;
  missing.pairs[3].scan_triangle = 123'456'789;
  EXPECT_THAT(refusal([&] { ScanAnimation(scan_, missing); }), HasSubstr("the scan has no triangle 123456789"));
  auto swapped = markers_;
  for (auto& marker : swapped.pairs)
    if (segment_name(segment_of_triangle(marker.template_triangle)) == "hand_left")
      marker.template_triangle += 3 * static_cast<std::uint32_t>(segment_triangles().size());  // hand_right
  EXPECT_THAT(refusal([&] { ScanAnimation(scan_, swapped); }), HasSubstr("left for right"));
}

TEST_F(ScanAnimationTest, IsReadByOtherProgramsAsItWasWritten) {
  ScanAnimation animation(scan_, markers_);
  const auto poses = animation.handle_poses(motion());
  const auto run = [&](AnimationFormat format, const char* name) {
    return export_animation(animation, poses, {.format = format, .output = folder_ / name});
  };
  Assimp::Importer importer;
  const auto report = run(AnimationFormat::skin, "skin.glb");
  EXPECT_EQ(report.frames, 3U);
  EXPECT_LT(report.skin_rms, 0.02);
  const auto* scene = importer.ReadFile((folder_ / "skin.glb").string(), 0);
  ASSERT_TRUE(scene && scene->mNumMeshes == 1 && scene->mNumAnimations == 1) << importer.GetErrorString();
  EXPECT_EQ(scene->mMeshes[0]->mNumVertices, scan_.mesh.positions.size());
  EXPECT_GT(scene->mMeshes[0]->mNumBones, 14U);
  EXPECT_EQ(scene->mAnimations[0]->mNumChannels, kBodySegments);
  run(AnimationFormat::morph, "morph.glb");
  scene = importer.ReadFile((folder_ / "morph.glb").string(), 0);
  ASSERT_TRUE(scene && scene->mMeshes[0]->mNumAnimMeshes == 3) << importer.GetErrorString();
  run(AnimationFormat::pc2, "scan.obj");
  scene = importer.ReadFile((folder_ / "scan.obj").string(), aiProcess_JoinIdenticalVertices);
  ASSERT_TRUE(scene) << importer.GetErrorString();
  EXPECT_EQ(scene->mMeshes[0]->mNumFaces, scan_.mesh.triangles.size());
  EXPECT_EQ(fs::file_size(folder_ / "scan.pc2"), 32 + 3 * 12 * scan_.mesh.positions.size());
}

}  // namespace
}  // namespace rotunda::recon
