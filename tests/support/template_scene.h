#pragma once
// Cameras around a posed body template, and the silhouettes it casts: motion capture's truth in closed form.
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "recon/body/body_template.h"
#include "recon/body/pose_equations.h"

namespace rotunda::tests {

// `count` cameras in a ring, 4 m away, looking at the middle of the stage from two heights.
inline std::vector<capture::CameraModel> ring_around_person(int count, int width = 240, int height = 240) {
  std::vector<capture::CameraModel> cameras;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    const Eigen::Vector3d centre(4.0 * std::cos(angle), 4.0 * std::sin(angle), i % 2 == 0 ? 1.0 : 2.2);
    const Eigen::Vector3d forwards = (Eigen::Vector3d(0, 0, 1.0) - centre).normalized(),
                          right = forwards.cross(Eigen::Vector3d::UnitZ()).normalized();
    capture::CameraModel camera;
    camera.name = "cam" + std::to_string(i);
    camera.width = width;
    camera.height = height;
    const double focal = 1.5 * height;
    camera.K << focal, 0, 0.5 * (width - 1), 0, focal, 0.5 * (height - 1), 0, 0, 1;
    camera.R.row(0) = right;
    camera.R.row(1) = forwards.cross(right);
    camera.R.row(2) = forwards;
    camera.t = -camera.R * centre;
    cameras.push_back(camera);
  }
  return cameras;
}

inline capture::Matte silhouette_of(const recon::TriangleMesh& mesh, const capture::CameraModel& camera) {
  constexpr int kShift = 4, kOne = 1 << kShift;
  capture::Matte matte{cv::Mat::zeros(camera.height, camera.width, CV_8UC1)};
  for (const auto& triangle : mesh.triangles) {
    std::vector<cv::Point> corners;
    for (const auto v : triangle)
      if (const auto pixel = capture::project(camera, mesh.positions[v].cast<double>()))
        corners.emplace_back(static_cast<int>(std::lround(pixel->x() * kOne)),
                             static_cast<int>(std::lround(pixel->y() * kOne)));
    if (corners.size() == 3) cv::fillConvexPoly(matte.alpha, corners, cv::Scalar(255), cv::LINE_8, kShift);
  }
  return matte;
}

inline recon::FrameOutlines outlines_of(const recon::BodyTemplate& body, const recon::Pose& pose,
                                        const std::vector<capture::CameraModel>& cameras) {
  const auto mesh = recon::pose_template(body, pose);
  recon::FrameOutlines frame;
  for (const auto& camera : cameras)
    frame.push_back({camera, recon::silhouette_outline(silhouette_of(mesh, camera), {.spacing_px = 4.0})});
  return frame;
}

// Mid-stride, arms swinging: upright, and nothing in it is symmetric. `phase` 0..1 is one cycle of the walk.
inline recon::Pose walking_pose(const recon::BodyTemplate& body, double phase) {
  using recon::BodyJoint;
  const double swing = std::sin(2.0 * std::numbers::pi * phase);
  auto pose = recon::rest_pose();
  const auto turn = [&](BodyJoint joint, double angle, const Eigen::Vector3d& axis) {
    pose.rotation[recon::index(joint)] =
        pose.rotation[recon::index(joint)] * Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  pose.root = {0.0, 0.0, recon::root_height_of(body.measures)};
  turn(BodyJoint::pelvis, 0.5, z);
  for (const double sign : {1.0, -1.0}) {
    const auto of = [&](BodyJoint left) { return sign > 0.0 ? left : recon::mirrored(left); };
    turn(of(BodyJoint::thigh_left), -0.1 - 0.45 * sign * swing, y);
    turn(of(BodyJoint::shank_left), 0.35 - 0.25 * sign * swing, y);
    turn(of(BodyJoint::upper_arm_left), 0.5 * sign * swing, y);
    turn(of(BodyJoint::upper_arm_left), -1.2 * sign, x);
    turn(of(BodyJoint::forearm_left), -0.5 * sign, z);
  }
  return pose;
}

}  // namespace rotunda::tests
