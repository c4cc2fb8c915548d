#pragma once
// Balls before cameras in closed form: their meshes, and pictures, mattes and depths by ray casting. World, metres.
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "capture/camera_model.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::tests {

struct Ball {
  Eigen::Vector3d centre;
  double radius = 1.0;
};

// Distance from `origin` along the unit `direction` to the ball's near side; infinity if the ray misses.
inline double distance_along(const Ball& ball, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d to = ball.centre - origin;
  const double along = to.dot(direction), missed2 = to.squaredNorm() - along * along;
  if (missed2 > ball.radius * ball.radius) return std::numeric_limits<double>::infinity();
  return along - std::sqrt(ball.radius * ball.radius - missed2);
}

// Rings of latitude, 2 * rings meridians; outward-facing, with exact normals.
inline void append_ball(const Ball& ball, int rings, recon::TriangleMesh& mesh) {
  const int meridians = 2 * rings;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < meridians; ++j) {
      const double polar = M_PI * i / rings, azimuth = 2.0 * M_PI * j / meridians;
      const Eigen::Vector3d normal(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                                   std::cos(polar));
      mesh.normals.push_back(normal.cast<float>());
      mesh.positions.push_back((ball.centre + ball.radius * normal).cast<float>());
    }
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * meridians + j % meridians); };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < meridians; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

struct BallPicture {
  cv::Mat rgb;    // CV_8UC3
  cv::Mat alpha;  // CV_8UC1
};

// Whether the ray passes an outline closely enough for its pixel to hold a part of it.
inline bool grazes(const Ball& ball, const capture::CameraModel& camera, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d to = ball.centre - camera.centre();
  const double missed = to.cross(direction).norm();
  return std::abs(missed - ball.radius) < 2.0 * to.norm() / std::min(camera.K(0, 0), camera.K(1, 1));
}

// Every pixel at an outline a mean over 4 x 4 rays, elsewhere one. `colour` is asked for (ball's index, point on it),
// bytes.
template <class ColourOf>
BallPicture picture_of(const capture::CameraModel& camera, std::span<const Ball> balls, const cv::Vec3f& backdrop,
                       const ColourOf& colour) {
  constexpr int kRays = 4;
  BallPicture picture{cv::Mat(camera.height, camera.width, CV_8UC3), cv::Mat(camera.height, camera.width, CV_8UC1)};
  const auto trace = [&](double x, double y) -> std::optional<cv::Vec3f> {
    const Eigen::Vector3d direction = capture::ray_through(camera, {x, y}).value();
    std::size_t hit = balls.size();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < balls.size(); ++i)
      if (const double d = distance_along(balls[i], camera.centre(), direction); d < nearest) nearest = d, hit = i;
    if (hit == balls.size()) return std::nullopt;
    return colour(hit, Eigen::Vector3d(camera.centre() + nearest * direction));
  };
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d direction = capture::ray_through(camera, {x, y}).value();
      const bool outline =
          std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) { return grazes(ball, camera, direction); });
      const int rays = outline ? kRays : 1;
      cv::Vec3f sum;
      int hits = 0;
      for (int ray = 0; ray < rays * rays; ++ray) {
        const auto seen = trace(x - 0.5 + (ray % rays + 0.5) / rays, y - 0.5 + (ray / rays + 0.5) / rays);
        sum += seen ? *seen : backdrop;
        hits += seen ? 1 : 0;
      }
      const double share = 1.0 / (rays * rays);
      for (int c = 0; c < 3; ++c) picture.rgb.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(sum[c] * share);
      picture.alpha.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255.0 * hits * share);
    }
  });
  return picture;
}

}  // namespace rotunda::tests
