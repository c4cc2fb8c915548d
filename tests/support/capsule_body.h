#pragma once
// Bodies built of capsules (a ball is one of no length), whose silhouettes through any camera model, signed distance
// and volume are known in closed form: truth for the hull's tests. World metres.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"

namespace rotunda::tests {

struct Capsule {
  Eigen::Vector3d a, b;
  double radius = 0.1;
};
using CapsuleBody = std::vector<Capsule>;

inline CapsuleBody ball(const Eigen::Vector3d& centre, double radius) {
  return {{centre, centre, radius}};
}

// A ring of `radius` in the plane spanned by two unit vectors: genus 1.
inline CapsuleBody ring(const Eigen::Vector3d& centre, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                        double radius, double thickness, int pieces = 24) {
  CapsuleBody body;
  const auto at = [&](int i) {
    const double angle = 2.0 * std::numbers::pi * i / pieces;
    return Eigen::Vector3d(centre + radius * (std::cos(angle) * u + std::sin(angle) * v));
  };
  for (int i = 0; i < pieces; ++i) body.push_back({at(i), at(i + 1), thickness});
  return body;
}

// A standing person of twelve capsules; with `hands_on_hips` the arms close two rings.
inline CapsuleBody person(bool hands_on_hips = false) {
  CapsuleBody body{
      {{0, 0, 0.95}, {0, 0, 1.35}, 0.14}, {{0, 0, 1.62}, {0, 0, 1.68}, 0.10}, {{0, 0, 1.35}, {0, 0, 1.62}, 0.06}};
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d shoulder(0, 0.17 * side, 1.40);
    const Eigen::Vector3d elbow =
        hands_on_hips ? Eigen::Vector3d(0, 0.48 * side, 1.18) : Eigen::Vector3d(0, 0.40 * side, 1.20);
    const Eigen::Vector3d hand =
        hands_on_hips ? Eigen::Vector3d(0, 0.14 * side, 0.98) : Eigen::Vector3d(0.1, 0.60 * side, 1.0);
    body.push_back({shoulder, elbow, 0.05});
    body.push_back({elbow, hand, 0.04});
    body.push_back({{0, 0.09 * side, 0.92}, {0.03, 0.13 * side, 0.5}, 0.08});
    body.push_back({{0.03, 0.13 * side, 0.5}, {0, 0.15 * side, 0.06}, 0.055});
  }
  return body;
}

inline double distance_to_segment(const Eigen::Vector3d& p, const Capsule& c) {
  const Eigen::Vector3d along = c.b - c.a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - c.a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - c.a - t * along).norm();
}

// Positive inside.
inline double signed_distance(const CapsuleBody& body, const Eigen::Vector3d& p) {
  double deepest = -1e9;
  for (const auto& c : body) deepest = std::max(deepest, c.radius - distance_to_segment(p, c));
  return deepest;
}

// How far a ray passes inside of a capsule's side, and how far along the ray that is.
struct RayPass {
  double depth = -1e9;
  double along = 1.0;
};
inline RayPass pass_of(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Capsule& c) {
  const Eigen::Vector3d along = c.b - c.a, from = origin - c.a;
  const double dd = along.squaredNorm(), rd = direction.dot(along), determinant = dd - rd * rd;
  double t = 0.0;  // on the segment, closest to the ray's line
  if (determinant > 1e-12 * std::max(dd, 1e-12)) t = (from.dot(along) - rd * from.dot(direction)) / determinant;
  t = std::clamp(t, 0.0, 1.0);
  const Eigen::Vector3d point = c.a + t * along;
  const double on_ray = std::max((point - origin).dot(direction), 1e-6);
  return {c.radius - (point - origin - on_ray * direction).norm(), on_ray};
}

// Does the ray come near the ball around a capsule? Spares most of the pixels the full test.
inline bool may_touch(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Capsule& c) {
  const Eigen::Vector3d to = 0.5 * (c.a + c.b) - origin;
  const double reach = 0.5 * (c.b - c.a).norm() + c.radius + 0.02 * to.norm();
  return (to - direction * to.dot(direction)).squaredNorm() < reach * reach;
}

// Coverage to first order: how far the pixel's ray passes inside the outline, in pixels, about one half.
inline capture::Matte matte_of(const CapsuleBody& body, const capture::CameraModel& camera) {
  capture::Matte matte{cv::Mat::zeros(camera.height, camera.width, CV_8UC1)};
  const double focal = std::sqrt(camera.K(0, 0) * camera.K(1, 1));
  const Eigen::Vector3d centre = camera.centre();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = capture::ray_through(camera, {static_cast<double>(x), static_cast<double>(y)});
      if (!ray || std::none_of(body.begin(), body.end(), [&](const auto& c) { return may_touch(centre, *ray, c); }))
        continue;
      double coverage = 0.0;
      for (const auto& c : body) {
        const auto pass = pass_of(centre, *ray, c);
        coverage = std::max(coverage, 0.5 + pass.depth * focal / pass.along);
      }
      matte.alpha.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0 * std::clamp(coverage, 0.0, 1.0));
    }
  return matte;
}

inline std::vector<capture::Matte> mattes_of(const CapsuleBody& body,
                                             const std::vector<capture::CameraModel>& cameras) {
  std::vector<capture::Matte> mattes;
  for (const auto& camera : cameras) mattes.push_back(matte_of(body, camera));
  return mattes;
}

}  // namespace rotunda::tests
