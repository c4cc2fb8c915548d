#include "recon/live_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/template_scene.h"

namespace rotunda::recon {
namespace {

// Somebody who walks on the spot before eight cameras of 240 x 240 pixels.
class WhoIsLive : public ::testing::Test {
 protected:
  FrameOutlines seen(double phase) const {
    return tests::outlines_of(body_, tests::walking_pose(body_, phase), cameras_);
  }
  FrameOutlines nobody() const {
    FrameOutlines frame;
    for (const auto& camera : cameras_)
      frame.push_back({camera, silhouette_outline({cv::Mat::zeros(camera.height, camera.width, CV_8UC1)})});
    return frame;
  }
  double error(const LiveMotionFrame& frame, double phase) const {
    const auto truth = joint_positions(body_.skeleton, tests::walking_pose(body_, phase)),
               found = joint_positions(frame.body.value().skeleton, frame.fit.pose);
    double sum = 0.0;
    for (std::size_t j = 0; j < kBodyJoints; ++j) sum += (truth[j] - found[j]).norm() / kBodyJoints;
    return sum;
  }

  const std::vector<capture::CameraModel> cameras_ = tests::ring_around_person(8);
  const BodyTemplate body_ = template_of_height(1.72);
  LiveMotion motion_;
};

TEST_F(WhoIsLive, IsFoundMeasuredAndFollowedWithoutAWord) {
  EXPECT_EQ(motion_.follow(seen(0.0)).state, LiveMotionState::recovered);
  LiveMotionFrame frame;
  for (int i = 1; i < 30; ++i) frame = motion_.follow(seen(0.04 * i));
  EXPECT_EQ(frame.state, LiveMotionState::tracked);
  EXPECT_NEAR(height_of(frame.body.value().measures), 1.72, 0.03);
  EXPECT_LT(error(frame, 0.04 * 29), 0.03);
}

TEST_F(WhoIsLive, IsFollowedAcrossFramesThatWereLeftOut) {
  for (int i = 0; i < 26; ++i) motion_.follow(seen(0.04 * i));
  LiveMotionFrame frame;
  for (int i = 26; i < 44; i += 3) frame = motion_.follow(seen(0.04 * i), 0.12);
  EXPECT_NE(frame.state, LiveMotionState::lost);
  EXPECT_LT(error(frame, 0.04 * 41), 0.035);
}

TEST_F(WhoIsLive, IsLostToldAndFoundAgain) {
  for (int i = 0; i < 26; ++i) motion_.follow(seen(0.04 * i));
  auto frame = motion_.follow(nobody());
  EXPECT_EQ(frame.state, LiveMotionState::lost);
  EXPECT_THAT(frame.why, ::testing::HasSubstr("0 of 8 silhouettes"));
  for (int i = 0; i < 30; ++i) frame = motion_.follow(nobody());
  EXPECT_EQ(frame.state, LiveMotionState::searching);
  EXPECT_THAT(frame.why, ::testing::HasSubstr("nobody"));
  EXPECT_FALSE(frame.body.has_value());
  frame = motion_.follow(seen(0.5));
  EXPECT_EQ(frame.state, LiveMotionState::recovered);
  EXPECT_LT(error(frame, 0.5), 0.04);
}

TEST_F(WhoIsLive, HasMattesOfHalfSize) {
  const auto full = tests::ring_around_person(2, 240, 240);
  std::vector<LiveView> views(1);
  views[0].slot = 1;
  for (auto& plane : views[0].matte.picture.planes) plane = cv::Mat::zeros(120, 120, CV_16UC1);
  views[0].matte.box = {40, 20, 30, 60};
  views[0].matte.alpha = cv::Mat(60, 30, CV_8UC1, cv::Scalar(255));
  const auto frame = live_outlines(views, full);
  ASSERT_EQ(frame.size(), 1U);
  EXPECT_EQ(frame[0].camera.name, full[1].name);
  EXPECT_EQ(frame[0].camera.width, 120);
  EXPECT_NEAR(frame[0].outline.area, 30.0 * 60.0, 100.0);
}

}  // namespace
}  // namespace rotunda::recon
