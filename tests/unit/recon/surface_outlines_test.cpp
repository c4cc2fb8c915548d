#include "recon/video/surface_outlines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "config/errors.h"
#include "recon/body/motion_capture.h"
#include "recon/sphere/resample.h"
#include "recon/track/body_surface.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

Eigen::Quaterniond turned(const Eigen::Vector3d& axis, double radians) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(radians, axis));
}

// Steps forward, lifts a knee and an arm, turns.
Pose pose_at(int frame) {
  auto pose = free_pose();
  const double t = 0.12 * frame;
  const auto turn = [&](BodyJoint joint, const Eigen::Vector3d& axis, double radians) {
    auto& rotation = pose.rotation[index(joint)];
    rotation = rotation * turned(axis, radians);
  };
  pose.root += Eigen::Vector3d(0.3 * t, 0.1, 0.0);
  turn(BodyJoint::pelvis, Eigen::Vector3d::UnitZ(), 0.4 + t);
  turn(BodyJoint::thigh_left, Eigen::Vector3d::UnitY(), -t);
  turn(BodyJoint::shank_left, Eigen::Vector3d::UnitY(), 1.2 * t);
  turn(BodyJoint::upper_arm_right, Eigen::Vector3d::UnitX(), -0.5 * t);
  return pose;
}

class SurfaceOutlinesOf : public ::testing::Test {
 protected:
  SurfaceOutlinesOf() { fs::create_directories(folder_); }
  ~SurfaceOutlinesOf() override { fs::remove_all(folder_); }
  const fs::path folder_ = fs::temp_directory_path() / ("rotunda_surface_outlines_" + std::to_string(::getpid()));
  const fs::path file_ = folder_ / "clip.mkv";
};

GeometryImage image_of(const BodyTemplate& body, const Pose& pose) {
  auto mesh = body_surface(body, pose, 0.02);
  const auto mapped = map_to_sphere(mesh);
  auto image = resample(mesh, mapped.map.value(), 6);
  image.colours.assign(image.positions.size(), {120, 130, 140});
  image.coverage.assign(image.positions.size(), 255);
  return image;
}

TEST_F(SurfaceOutlinesOf, AClipTellsHowThePersonMoved) {
  constexpr int kFrames = 6;
  const auto body = template_of_height(1.72);
  std::vector<GeometryImage> images;
  for (int frame = 0; frame < kFrames; ++frame) images.push_back(image_of(body, pose_at(frame)));
  write_geometry_video(file_, images);
  SurfaceOutlines silhouettes(file_);
  const auto report = capture_motion(silhouettes, {}, {}, {});
  ASSERT_EQ(report.motion.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_NEAR(height_of(report.motion.body.measures), 1.72, 0.04);
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto truth = joint_positions(body.skeleton, pose_at(frame)),
               found = joint_positions(report.motion.body.skeleton,
                                       report.motion.frames[static_cast<std::size_t>(frame)].fit.pose);
    double error = 0.0;
    for (std::size_t j = 0; j < kBodyJoints; ++j) error += (truth[j] - found[j]).norm() / kBodyJoints;
    EXPECT_LT(error, 0.025) << frame;
  }
}

TEST_F(SurfaceOutlinesOf, WhatIsNobodyIsRefusedWithWhatToLookAt) {
  write_geometry_video(file_, std::vector{test::round_geometry_image({.radii = {0.5F, 0.5F, 0.5F}})});
  SurfaceOutlines silhouettes(file_);
  try {
    capture_motion(silhouettes, {}, {}, {});
    FAIL() << "a ball has no skeleton";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(file_.string()));
  }
}

}  // namespace
}  // namespace rotunda::recon
