#pragma once
// Calibration boards as cameras would see them, and a small rig to see them with: for tests that need truth. Metres,
// z up.
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <vector>

#include "capture/calibration/board_print.h"
#include "capture/calibration/bundle_adjustment.h"
#include "capture/camera_model.h"

namespace rotunda::tests {

struct BoardLook {
  double blur_px = 0.6;
  double noise = 0.0;                 // standard deviation, 8-bit levels
  double black = 0.05, white = 0.75;  // linear light
  double background = 0.25;
  unsigned seed = 1;
};

inline std::uint8_t to_srgb(double linear) {
  const double s = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(s, 0.0, 1.0)));
}

// One camera's view of one board (face on, one square of white about it), CV_8UC1.
inline cv::Mat board_picture(const capture::CameraModel& camera, const capture::BoardPrint& print,
                             const Eigen::Isometry3d& world_from_board, const BoardLook& look = {}) {
  cv::Mat linear(camera.height, camera.width, CV_32FC1, cv::Scalar(look.background));
  const Eigen::Isometry3d board_from_world = world_from_board.inverse();
  const auto& board = print.board();
  const Eigen::Vector2d half = (0.5 * Eigen::Vector2d(board.columns, board.rows).array() + 0.5) * board.square;
  const Eigen::Vector3d eye = board_from_world * camera.centre();
  constexpr int kSub = 3;
  // Rays are dear: only those about the plate are followed.
  Eigen::AlignedBox2d about;
  for (int i = -6; i <= 6; ++i)
    for (int j = -6; j <= 6; ++j)
      if (const auto pixel =
              capture::project(camera, world_from_board * Eigen::Vector3d(half.x() * i / 6.0, half.y() * j / 6.0, 0.0)))
        about.extend(*pixel);
  const int left = about.isEmpty() ? 0 : std::max(0, static_cast<int>(about.min().x()) - 6),
            top = about.isEmpty() ? 0 : std::max(0, static_cast<int>(about.min().y()) - 6),
            right_end = about.isEmpty() ? 0 : std::min(camera.width, static_cast<int>(about.max().x()) + 7),
            bottom = about.isEmpty() ? 0 : std::min(camera.height, static_cast<int>(about.max().y()) + 7);
  const auto hit = [&](int x, int y) -> std::optional<Eigen::Vector2d> {
    const auto ray = capture::ray_through(camera, Eigen::Vector2d(x, y));
    if (!ray) return std::nullopt;
    const Eigen::Vector3d way = board_from_world.linear() * *ray;
    if (way.z() >= 0.0) return std::nullopt;
    return Eigen::Vector2d((eye - way * (eye.z() / way.z())).head<2>());
  };
  // Where the pixels' middles meet the board's plane, and those of the pixels around the region.
  const int width = right_end - left + 2;
  std::vector<std::optional<Eigen::Vector2d>> hits;
  if (eye.z() > 0.0)
    for (int y = top - 1; y <= bottom; ++y)
      for (int x = left - 1; x <= right_end; ++x) hits.push_back(hit(x, y));
  for (int y = top; y < bottom && !hits.empty(); ++y)
    for (int x = left; x < right_end; ++x) {
      const auto* at_pixel = &hits[static_cast<std::size_t>((y - top + 1) * width + x - left + 1)];
      const auto &middle = at_pixel[0], &before = at_pixel[-1], &after = at_pixel[1], &above = at_pixel[-width],
                 &below = at_pixel[width];
      if (!middle || !before || !after || !above || !below) continue;
      if ((middle->cwiseAbs() - 1.3 * half).maxCoeff() > 0.0) continue;
      const Eigen::Vector2d u = 0.5 * (*after - *before), v = 0.5 * (*below - *above);
      const Eigen::Vector2d whole = 0.5 * (u.cwiseAbs() + v.cwiseAbs()), box = whole / kSub;
      const auto lit = [&](double white) { return look.black + (look.white - look.black) * white; };
      const double inmost = (half - middle->cwiseAbs() - whole).minCoeff();
      if (const auto plain =
              inmost > 0.0 ? print.plain(middle->x(), middle->y(), whole.x(), whole.y()) : std::nullopt) {
        linear.at<float>(y, x) = static_cast<float>(lit(*plain));
        continue;
      }
      double sum = 0.0;
      for (int j = 0; j < kSub; ++j)
        for (int i = 0; i < kSub; ++i) {
          const Eigen::Vector2d at = *middle + u * ((i + 0.5) / kSub - 0.5) + v * ((j + 0.5) / kSub - 0.5);
          const bool on = (at.cwiseAbs() - half).maxCoeff() < 0.0;
          sum += on ? lit(print.mean(at.x(), at.y(), box.x(), box.y())) : look.background;
        }
      linear.at<float>(y, x) = static_cast<float>(sum / (kSub * kSub));
    }
  if (look.blur_px > 0.0) cv::GaussianBlur(linear, linear, {}, look.blur_px);
  std::mt19937 random(look.seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  cv::Mat picture(linear.size(), CV_8UC1);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x)
      picture.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(to_srgb(linear.at<float>(y, x)) + look.noise * noise(random));
  return picture;
}

// A camera at `centre` that looks at `target`, z upwards.
inline capture::CameraModel camera_at(const std::string& name, const Eigen::Vector3d& centre,
                                      const Eigen::Vector3d& target, int width, int height, double f) {
  capture::CameraModel camera;
  camera.name = name;
  camera.width = width;
  camera.height = height;
  camera.K << f, 0, 0.5 * (width - 1) + 3.0, 0, f, 0.5 * (height - 1) - 2.0, 0, 0, 1;
  const Eigen::Vector3d forward = (target - centre).normalized(),
                        right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  camera.R.row(0) = right.transpose();
  camera.R.row(1) = forward.cross(right).transpose();
  camera.R.row(2) = forward.transpose();
  camera.t = -camera.R * centre;
  return camera;
}

// `count` cameras on a ring of 3.6 m that look at the middle of the stage, with distortion of their own.
inline std::vector<capture::CameraModel> board_rig(int count, int width = 720, int height = 576, double f = 700.0) {
  std::vector<capture::CameraModel> cameras;
  for (int i = 0; i < count; ++i) {
    const double a = 2.0 * M_PI * i / count;
    auto camera = camera_at("cam0" + std::to_string(i), {3.6 * std::cos(a), 3.6 * std::sin(a), 1.3 + 0.9 * (i % 3)},
                            {0.0, 0.0, 0.95}, width, height, f * (1.0 + 0.01 * i));
    camera.distortion << -0.20 + 0.01 * i, 0.05, 0.0003, -0.0002, 0.0;
    cameras.push_back(camera);
  }
  return cameras;
}

// Where a board is carried: all over the volume, its face to every side, tilted; the last lies on the floor.
inline std::vector<Eigen::Isometry3d> board_walk(int count, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < count; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    if (i + 1 < count) {
      const double facing = 2.0 * M_PI * i / count * 3.0 + 0.2 * u(random);
      pose.translation() = Eigen::Vector3d(1.1 * u(random), 0.8 * u(random), 1.0 + 0.45 * u(random));
      Eigen::Matrix3d upright;
      upright << Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX();
      pose.linear() = (Eigen::AngleAxisd(facing, Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(0.5 * u(random), Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(0.35 * u(random), Eigen::Vector3d::UnitX()))
                          .toRotationMatrix() *
                      upright;
    }
    poses.push_back(pose);
  }
  return poses;
}

// Every corner that a camera has before it at an angle of more than 15 degrees, exactly or with noise (pixels a axis).
inline std::vector<capture::Sighting> sightings_of(std::span<const capture::CameraModel> cameras,
                                                   const capture::Board& board,
                                                   std::span<const Eigen::Isometry3d> poses, double noise_px = 0.0,
                                                   unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto positions = capture::corner_positions(board);
  std::vector<capture::Sighting> sightings;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera)
    for (std::size_t moment = 0; moment < poses.size(); ++moment) {
      capture::Sighting sighting{.camera = camera, .moment = moment};
      for (std::size_t i = 0; i < positions.size(); ++i) {
        const Eigen::Vector3d at = poses[moment] * positions[i];
        if ((cameras[camera].centre() - at).normalized().dot(poses[moment].linear().col(2)) < 0.25) continue;
        const auto pixel = capture::project(cameras[camera], at);
        if (!pixel || pixel->minCoeff() < 4 || pixel->x() > cameras[camera].width - 5 ||
            pixel->y() > cameras[camera].height - 5)
          continue;
        const Eigen::Vector2d off(normal(random), normal(random));
        sighting.corners.push_back({static_cast<int>(i), *pixel + noise_px * off, noise_px});
      }
      if (capture::span_an_area(sighting.corners, board)) sightings.push_back(sighting);
    }
  return sightings;
}

}  // namespace rotunda::tests
