#pragma once
// A ball painted with a smooth pattern, maybe with a round dent, as cameras see it: for what compares pictures. World
// metres.
#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"

namespace rotunda::tests {

struct PaintedBall {
  Eigen::Vector3d centre{0.0, 0.0, 1.0};
  double radius = 0.3;
  Eigen::Vector3d dent{0.0, 0.0, 0.0};  // centre of the ball that is taken away
  double dent_radius = 0.0;             // 0: no dent
  double detail = 1.0;                  // of the pattern: 1 has waves of 65 to 170 mm, 4 of a quarter
  double repeat = 0.0;                  // metres after which it is the same again along x, y and z; 0: never
  double repeat_radius = 0.0;           // it repeats so far about this place alone; 0: everywhere
  Eigen::Vector3d repeat_at{0.0, 0.0, 0.0};
};

// Positive inside.
inline double signed_distance(const PaintedBall& ball, const Eigen::Vector3d& p) {
  const double inside = ball.radius - (p - ball.centre).norm();
  return ball.dent_radius > 0.0 ? std::min(inside, (p - ball.dent).norm() - ball.dent_radius) : inside;
}

// Colour of a place on it: smooth, so that pixels need no filtering.
inline cv::Vec3b paint_at(const Eigen::Vector3d& place, double detail) {
  const Eigen::Vector3d p = detail * place;
  const auto channel = [&](double a, double b, double c) {
    const double wave =
        std::sin(a * p.x() + b * p.z()) + std::sin(b * p.y() - c * p.x()) + std::sin(c * p.z() + a * p.y());
    return cv::saturate_cast<std::uint8_t>(128.0 + 38.0 * wave);
  };
  return {channel(41, 83, 59), channel(67, 37, 97), channel(53, 71, 89)};
}

inline cv::Vec3b paint_at(const PaintedBall& ball, const Eigen::Vector3d& place) {
  const bool elsewhere = ball.repeat_radius > 0.0 && (place - ball.repeat_at).norm() > ball.repeat_radius;
  if (ball.repeat <= 0.0 || elsewhere) return paint_at(place, ball.detail);
  const Eigen::Array3d turn = 2.0 * M_PI / ball.repeat * place.array();
  const auto grey = cv::saturate_cast<std::uint8_t>(128.0 + 30.0 * turn.sin().sum());
  return {grey, grey, grey};
}

// Where the ray first meets it.
inline std::optional<Eigen::Vector3d> first_hit(const PaintedBall& ball, const Eigen::Vector3d& origin,
                                                const Eigen::Vector3d& direction) {
  const double nearest = (ball.centre - origin).dot(direction);
  if ((origin + nearest * direction - ball.centre).norm() > ball.radius) return std::nullopt;
  double t = nearest - ball.radius;
  for (int i = 0; i < 400; ++i) {  // sphere tracing
    const double outside = -signed_distance(ball, origin + t * direction);
    if (outside < 1e-6) return origin + t * direction;
    t += outside;
    if (t > nearest + ball.radius) return std::nullopt;
  }
  return origin + t * direction;
}

struct PaintedView {
  cv::Mat rgb;  // black where the ball is not
  capture::Matte matte;
};

inline PaintedView view_of(const PaintedBall& ball, const capture::CameraModel& camera) {
  constexpr int kSub = 4;  // rays a pixel, along each side, of the matte
  PaintedView view{cv::Mat::zeros(camera.height, camera.width, CV_8UC3),
                   {cv::Mat::zeros(camera.height, camera.width, CV_8UC1)}};
  const Eigen::Vector3d centre = camera.centre();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto middle = capture::ray_through(camera, {static_cast<double>(x), static_cast<double>(y)});
      const Eigen::Vector3d to = ball.centre - centre;
      if (!middle || (to - *middle * to.dot(*middle)).norm() > ball.radius + 0.1) continue;
      if (const auto hit = first_hit(ball, centre, *middle)) view.rgb.at<cv::Vec3b>(y, x) = paint_at(ball, *hit);
      int covered = 0;
      for (int i = 0; i < kSub * kSub; ++i) {
        const Eigen::Vector2d pixel(x + (i % kSub + 0.5) / kSub - 0.5, y + (i / kSub + 0.5) / kSub - 0.5);
        const auto ray = capture::ray_through(camera, pixel);
        covered += ray && first_hit(ball, centre, *ray) ? 1 : 0;
      }
      view.matte.alpha.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(255 * covered / (kSub * kSub));
    }
  return view;
}

}  // namespace rotunda::tests
