#include "recon/hull/camera_agreement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "tests/support/capsule_body.h"

namespace rotunda::recon {
namespace {

using capture::CameraModel;

constexpr int kFrames = 5;

std::vector<CameraModel> rig(int cameras) {
  return simulator::camera_layout({.cameras = cameras, .width = 200, .height = 160});
}

double focal(const CameraModel& camera) {
  return camera.K(0, 0);
}

// Somebody who walks a step a frame.
tests::CapsuleBody walker(int frame) {
  auto body = tests::person();
  const Eigen::Vector3d step(0.12 * (frame - kFrames / 2), 0.06 * frame - 0.1, 0.0);
  for (auto& capsule : body) capsule.a += step, capsule.b += step;
  return body;
}

std::vector<OutlinesOverTime> seen_by(const std::vector<CameraModel>& cameras, bool walks = true) {
  std::vector<OutlinesOverTime> outlines(cameras.size());
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto mattes = tests::mattes_of(walker(walks ? frame : kFrames / 2), cameras);
    for (std::size_t i = 0; i < cameras.size(); ++i) outlines[i].push_back(convex_outline(cameras[i], mattes[i]));
  }
  return outlines;
}

// Somebody leant against it.
CameraModel knocked(CameraModel camera, double yaw_px, double pitch_px, double roll_deg) {
  const Eigen::Vector3d centre = camera.centre(),
                        turn(-pitch_px / focal(camera), yaw_px / focal(camera), roll_deg * std::numbers::pi / 180.0);
  camera.R = Eigen::Matrix3d(Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * camera.R);
  camera.t = -camera.R * centre;
  return camera;
}

}  // namespace

TEST(CameraAgreement, CamerasThatStandWhereTheyWereAreLeftInPeace) {
  const auto cameras = rig(8);
  for (const auto& shift : camera_shifts(cameras, seen_by(cameras))) {
    ASSERT_TRUE(shift.has_value());
    EXPECT_FALSE(shift->moved);
    EXPECT_LT(shift->shift_px, 0.4);
    EXPECT_FALSE(shift->still);
  }
}

TEST(CameraAgreement, TurnedCamerasAreFoundWithTheirPixelsAndNoOthers) {
  const auto calibrated = rig(8);
  auto now = calibrated;
  now[2] = knocked(now[2], 8.0, 3.0, 0.0);
  now[5] = knocked(now[5], 0.0, -3.0, 1.5);
  const auto shifts = camera_shifts(calibrated, seen_by(now));
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    ASSERT_TRUE(shifts[i].has_value()) << i;
    EXPECT_EQ(shifts[i]->moved, i == 2 || i == 5) << i << ": " << shifts[i]->shift_px;
  }
  // A tenth: a picture moves by f tan of the turn, and its lens is not a pinhole.
  EXPECT_NEAR(shifts[2]->at_middle.x(), 8.0, 0.8);
  EXPECT_NEAR(shifts[2]->at_middle.y(), 3.0, 0.5);
  EXPECT_NEAR(shifts[5]->at_middle.y(), -3.0, 0.5);
  EXPECT_NEAR(shifts[5]->roll_deg, 1.5, 0.3);
  const auto mended = turned(calibrated[2], *shifts[2]);
  EXPECT_LT((mended.R - now[2].R).norm(), 0.01);
  EXPECT_LT((mended.centre() - calibrated[2].centre()).norm(), 1e-9);
}

TEST(CameraAgreement, TwoDegreesAreFoundInAMirroredWorldToo) {
  auto calibrated = rig(6);
  for (auto& camera : calibrated) camera.R = Eigen::Matrix3d(camera.R * Eigen::Vector3d(-1, 1, 1).asDiagonal());
  auto now = calibrated;
  const double two_degrees = focal(now[1]) * std::tan(2.0 * std::numbers::pi / 180.0);
  now[1] = knocked(now[1], two_degrees, 0.0, 0.0);
  const auto shifts = camera_shifts(calibrated, seen_by(now));
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    ASSERT_TRUE(shifts[i].has_value()) << i;
    EXPECT_EQ(shifts[i]->moved, i == 1) << i;
  }
  EXPECT_NEAR(shifts[1]->at_middle.x(), two_degrees, 0.1 * two_degrees);
}

TEST(CameraAgreement, OfAStillPerformerOnlyWhatIsGrossIsTold) {
  const auto calibrated = rig(8);
  auto now = calibrated;
  now[3] = knocked(now[3], 0.0, 4.0, 0.0);
  now[1] = knocked(now[1], 14.0, 0.0, 0.0);
  const auto shifts = camera_shifts(calibrated, seen_by(now, /*walks=*/false));
  ASSERT_TRUE(shifts[3] && shifts[1]);
  EXPECT_TRUE(shifts[3]->still);
  EXPECT_FALSE(shifts[3]->moved);
  EXPECT_NEAR(shifts[3]->shift_px, 4.0, 1.0);
  EXPECT_TRUE(shifts[1]->moved);
}

TEST(CameraAgreement, NothingIsToldWhereNothingCanBe) {
  const auto three = rig(3);
  for (const auto& shift : camera_shifts(three, seen_by(three))) EXPECT_FALSE(shift.has_value());
  const auto cameras = rig(6);
  auto outlines = seen_by(cameras);
  for (auto& outline : outlines[4]) outline.is_cut = true;
  outlines[5].assign(kFrames, {});
  const auto shifts = camera_shifts(cameras, outlines);
  EXPECT_FALSE(shifts[4] || shifts[5]);
  EXPECT_TRUE(shifts[0].has_value());
  EXPECT_THROW(camera_shifts(cameras, std::vector<OutlinesOverTime>(2)), InvalidInput);
}

TEST(ConvexOutline, LiesOnTheBallsOutlineAndTellsWhatIsCut) {
  const auto cameras = rig(6);
  const auto body = tests::ball({0.1, 0.0, 1.0}, 0.3);
  const auto outline = convex_outline(cameras[0], tests::matte_of(body, cameras[0]));
  EXPECT_FALSE(outline.is_cut);
  ASSERT_GT(outline.corners.size(), 20U);
  const Eigen::Vector3d to = body.front().a - cameras[0].centre();
  for (const auto& corner : outline.corners) {
    const Eigen::Vector3d ray = (cameras[0].R.transpose() * corner.homogeneous()).normalized();
    const double off_m = (to - ray * to.dot(ray)).norm() - 0.3;
    EXPECT_LT(std::abs(off_m) * focal(cameras[0]) / to.norm(), 0.15) << "pixels";
  }
  EXPECT_TRUE(convex_outline(cameras[0], tests::matte_of(tests::ball({0.0, 0.0, 2.1}, 0.5), cameras[0])).is_cut);
  EXPECT_TRUE(convex_outline(cameras[0], {cv::Mat::zeros(160, 200, CV_8UC1)}).corners.empty());
  EXPECT_THROW(convex_outline(cameras[0], {cv::Mat::zeros(10, 10, CV_8UC1)}), InvalidInput);
}

}  // namespace rotunda::recon
