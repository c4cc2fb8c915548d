#include "recon/body/body_tracker.h"

#include <assimp/scene.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <assimp/Importer.hpp>
#include <filesystem>

#include "recon/body/body_track.h"
#include "recon/body/captured_motion.h"
#include "recon/body/limb_starts.h"
#include "recon/export/motion_glb.h"
#include "tests/support/template_scene.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;
using tests::outlines_of;
using tests::ring_around_person;
using tests::walking_pose;

double mean_joint_error(const Skeleton& a, const Pose& pose, const Skeleton& b, const Pose& truth) {
  const auto found = joint_positions(a, pose), expected = joint_positions(b, truth);
  double sum = 0.0;
  for (std::size_t j = 0; j < kBodyJoints; ++j) sum += (found[j] - expected[j]).norm();
  return sum / static_cast<double>(kBodyJoints);
}

BodyStart start_of(double height, double explained, double residual) {
  BodyStart start{template_of_height(height), {}};
  start.fit.explained = explained;
  start.fit.residual = residual;
  return start;
}

TEST(BodyStart, TheMostCredibleAgreesOnTheHeightAndFitsBest) {
  const auto crouch = start_of(2.1, 0.73, 0.035), leap = start_of(1.9, 0.85, 0.024);
  const std::vector<BodyStart> starts{crouch, leap,   start_of(1.70, 0.86, 0.028), start_of(1.74, 0.88, 0.025),
                                      crouch, crouch, start_of(1.68, 0.87, 0.030)};
  EXPECT_EQ(most_credible(starts), 3U);
  EXPECT_EQ(most_credible({crouch}), 0U) << "better than none";
  EXPECT_EQ(most_credible({start_of(1.7, 0.5, 0.02)}), std::nullopt);
  EXPECT_EQ(most_credible({}), std::nullopt);
}

// A pixel is 11 mm here, one of the distance field 22.
TEST(PoseFit, CarriesAPoseNearbyOntoTheSilhouettes) {
  const auto body = template_of_height(1.75);
  const auto truth = walking_pose(body, 0.2);
  auto start = walking_pose(body, 0.1);
  start.root += Vector3d(0.06, -0.05, 0.03);
  const auto frame = outlines_of(body, truth, ring_around_person(8));
  const auto fit = fit_pose(body, frame, start, {.iterations = 15});
  EXPECT_GT(mean_joint_error(body.skeleton, start, body.skeleton, truth), 0.07);
  EXPECT_LT(mean_joint_error(body.skeleton, fit.pose, body.skeleton, truth), 0.015);
  EXPECT_LT(fit.residual, 0.022);
  EXPECT_GT(fit.explained, 0.9);
}

TEST(PoseFit, IsTheSameOnOneThreadAndOnMany) {
  const auto body = template_of_height(1.75);
  const auto frame = outlines_of(body, walking_pose(body, 0.2), ring_around_person(4));
  const auto many = fit_pose(body, frame, walking_pose(body, 0.15), {.iterations = 3});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = fit_pose(body, frame, walking_pose(body, 0.15), {.iterations = 3});
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    EXPECT_EQ(many.pose.rotation[j].coeffs(), alone.pose.rotation[j].coeffs());
}

// Somebody slimmer, shorter in the leg and longer in the arm than the tables have it.
TEST(BodyStart, FindsAStrangerInMidStride) {
  auto measures = measures_of_height(1.68);
  for (const auto leg : {BodyMeasure::thigh, BodyMeasure::shank}) measures[index(leg)] *= 0.96;
  for (const auto arm : {BodyMeasure::upper_arm, BodyMeasure::forearm}) measures[index(arm)] *= 1.05;
  for (const auto width : {BodyMeasure::waist_breadth, BodyMeasure::thigh_width}) measures[index(width)] *= 0.85;
  const auto stranger = make_template(measures);
  const auto truth = walking_pose(stranger, 0.2);
  const auto start = start_body(outlines_of(stranger, truth, ring_around_person(8)), std::nullopt);
  ASSERT_TRUE(start);
  EXPECT_NEAR(height_of(start->body.measures), height_of(measures), 0.03);
  EXPECT_LT(mean_joint_error(start->body.skeleton, start->fit.pose, stranger.skeleton, truth), 0.04);
}

TEST(BodyStart, FindsNobodyInEmptySilhouettesNorInSomebodyLyingDown) {
  const auto body = template_of_height(1.75);
  const auto cameras = ring_around_person(6);
  auto lying = walking_pose(body, 0.2);
  lying.rotation[0] = Eigen::AngleAxisd(-1.55, Vector3d::UnitY());
  lying.root.z() = 0.3;
  EXPECT_FALSE(start_body(outlines_of(body, lying, cameras), std::nullopt));
  FrameOutlines empty;
  for (const auto& camera : cameras)
    empty.push_back({camera, silhouette_outline({cv::Mat::zeros(camera.height, camera.width, CV_8UC1)})});
  EXPECT_FALSE(start_body(empty, std::nullopt));
}

TEST(BodyTracker, TellsWhenNobodyIsSeenAndGoesOnAfterwards) {
  const auto body = template_of_height(1.75);
  const auto cameras = ring_around_person(6);
  const auto frame_at = [&](double phase) { return outlines_of(body, walking_pose(body, phase), cameras); };
  BodyTracker tracker(body, fit_pose(body, frame_at(0.0), walking_pose(body, 0.0), {}), {});
  EXPECT_EQ(tracker.track(frame_at(0.05)).state, TrackState::tracked);
  FrameOutlines empty;
  for (const auto& camera : cameras)
    empty.push_back({camera, silhouette_outline({cv::Mat::zeros(camera.height, camera.width, CV_8UC1)})});
  const auto lost = tracker.track(empty);
  EXPECT_EQ(lost.state, TrackState::lost);
  EXPECT_EQ(lost.loss, "0 of 6 silhouettes show anybody");
  EXPECT_EQ(lost.fit.confidence[0], 0.0);
  const auto again = tracker.track(frame_at(0.5));  // the legs have changed places meanwhile
  EXPECT_EQ(again.state, TrackState::recovered);
  EXPECT_LT(mean_joint_error(body.skeleton, again.fit.pose, body.skeleton, walking_pose(body, 0.5)), 0.03);
}

// Somebody standing with the left forearm raised in front of the chest; and tracked from there with the arm hanging
// behind the back, as after a quick move that went unseen.
TEST(BodyTracker, FindsAnArmThatIsHeldOtherwise) {
  const auto body = template_of_height(1.75);
  auto truth = walking_pose(body, 0.0);
  truth.rotation[index(BodyJoint::forearm_left)] = Eigen::AngleAxisd(-2.2, Vector3d::UnitZ());
  auto wrong = truth;
  wrong.rotation[index(BodyJoint::upper_arm_left)] =
      truth.rotation[index(BodyJoint::upper_arm_left)] * Eigen::AngleAxisd(2.4, Vector3d::UnitY());
  const auto hand = [&](const Pose& pose) {
    return (joint_positions(body.skeleton, pose)[index(BodyJoint::hand_left)] -
            joint_positions(body.skeleton, truth)[index(BodyJoint::hand_left)])
        .norm();
  };
  const auto frame = outlines_of(body, truth, ring_around_person(8));
  const auto caught = fit_pose(body, frame, wrong, {.iterations = 12});
  ASSERT_GT(hand(caught.pose), 0.08) << "no local minimum: it tests nothing";
  BodyTracker tracker(body, caught, {});
  TrackedPose last;
  bool told = false;
  for (int i = 0; i < 8; ++i) {  // once in as many frames it looks
    last = tracker.track(frame);
    told |= last.state == TrackState::recovered;
  }
  EXPECT_LT(hand(last.fit.pose), 0.04);
  EXPECT_TRUE(told);
}

TEST(BodyTracker, FindsLegsThatAreHeldOtherwise) {
  const auto body = template_of_height(1.75);
  const auto truth = walking_pose(body, 0.25);
  const auto frame = outlines_of(body, truth, ring_around_person(8));
  const auto caught = fit_pose(body, frame, legs_swapped(truth), {.iterations = 12, .first_scale = 0.04});
  ASSERT_GT(mean_joint_error(body.skeleton, caught.pose, body.skeleton, truth), 0.08) << "no local minimum";
  BodyTracker tracker(body, caught, {});
  TrackedPose last;
  for (int i = 0; i < 8; ++i) last = tracker.track(frame);
  EXPECT_LT(mean_joint_error(body.skeleton, last.fit.pose, body.skeleton, truth), 0.02);
}

TEST(BodyTrack, IsNotFilteredAcrossACut) {
  const auto body = template_of_height(1.75);
  BodyTrack track{.body = body, .first_frame = 0, .poses = {}};
  for (int i = 0; i < 20; ++i) {
    auto pose = walking_pose(body, 0.04 * i);
    pose.root.x() += 0.05 * i - (i < 12 ? 0.0 : 1.5);  // as two clips in one take
    track.poses.emplace_back(pose);
  }
  const auto steady = steadied(track);
  for (std::size_t i = 0; i < 20; ++i)
    EXPECT_LT((steady.poses[i]->root - track.poses[i]->root).norm(), 0.005) << "frame " << i;
}

// Centimetres, y up, facing z: ours (x, y, z) is (y, z, x) there.
TEST(CapturedMotion, IsTheSameMotionAsBvh) {
  CapturedMotion motion{.body = template_of_height(1.7), .fps = 25.0, .first_frame = 3, .frames = {}};
  for (const double phase : {0.1, 0.3}) {
    TrackedPose frame;
    frame.fit.pose = walking_pose(motion.body, phase);
    motion.frames.push_back(frame);
  }
  const auto bvh = parse_bvh(bvh_text(bvh_of(motion)));
  ASSERT_EQ(bvh.frames, 2U);
  EXPECT_DOUBLE_EQ(bvh.frame_time, 0.04);
  const auto in_file = joint_transforms(bvh, 1);
  const auto ours = joint_positions(motion.body.skeleton, motion.frames[1].fit.pose);
  std::size_t found = 0;
  for (std::size_t i = 0; i < bvh.joints.size(); ++i)
    for (std::size_t j = 0; j < kBodyJoints; ++j) {
      if (bvh.joints[i].name != to_string(body_joint(j))) continue;
      const Vector3d expected = 100.0 * Vector3d(ours[j].y(), ours[j].z(), ours[j].x());
      EXPECT_LT((in_file[i].translation() - expected).norm(), 0.01) << bvh.joints[i].name;
      ++found;
    }
  EXPECT_EQ(found, kBodyJoints);
}

// Read by assimp, a stranger to our writer: z up is y up there, (x, z, -y).
TEST(CapturedMotion, IsTheSameMotionAsGltf) {
  CapturedMotion motion{.body = template_of_height(1.7), .fps = 25.0, .first_frame = 0, .frames = {}};
  for (const double phase : {0.1, 0.3, 0.5}) {
    TrackedPose frame;
    frame.fit.pose = walking_pose(motion.body, phase);
    motion.frames.push_back(frame);
  }
  const auto file = std::filesystem::path(testing::TempDir()) / "motion.glb";
  write_motion_glb(file, motion);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  EXPECT_EQ(scene->mNumMeshes, kBodySegments);
  ASSERT_EQ(scene->mNumAnimations, 1U);
  const auto& animation = *scene->mAnimations[0];
  EXPECT_EQ(animation.mNumChannels, kBodyJoints);
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const auto& channel = *animation.mChannels[c];
    ASSERT_EQ(channel.mNumRotationKeys, 3U);
    for (std::size_t j = 0; j < kBodyJoints; ++j) {
      if (channel.mNodeName.C_Str() != std::string(to_string(body_joint(j)))) continue;
      const auto& q = channel.mRotationKeys[2].mValue;
      const Eigen::Quaterniond read(q.w, q.x, q.y, q.z);
      EXPECT_LT(read.angularDistance(motion.frames[2].fit.pose.rotation[j]), 1e-3);
    }
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace rotunda::recon
