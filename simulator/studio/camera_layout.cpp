#include "simulator/studio/camera_layout.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/errors.h"
#include "simulator/studio/light.h"

namespace rotunda::simulator {
namespace {

constexpr double kHighElevation = 55.0 * std::numbers::pi / 180.0;

Eigen::Vector3d on_ring(double azimuth, const LayoutOptions& options) {
  return {options.radius * std::cos(azimuth), options.radius * std::sin(azimuth), options.ring_height};
}

Eigen::Vector3d high_up(double azimuth, const LayoutOptions& options) {
  const double up = std::clamp((options.rig_height - options.aim_height) / options.radius, 0.0, 1.0);
  const double elevation = std::min(kHighElevation, std::asin(up));
  const double across = options.radius * std::cos(elevation);
  return {across * std::cos(azimuth), across * std::sin(azimuth),
          options.aim_height + options.radius * std::sin(elevation)};
}

// A lamp stands between the camera and some corner of the stage.
bool is_behind_a_lamp(const Eigen::Vector3d& centre) {
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d way = kStageVolume.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - centre;
    for (const auto& lamp : lamps())
      if (const auto hit = hit_lamp(lamp, centre, way.normalized()); hit && hit->distance < way.norm()) return true;
  }
  return false;
}

// Of the high camera `i` of `high`: evenly about the stage, then to the nearest side where it looks past the lamps.
Eigen::Vector3d high_place(int i, int high, const LayoutOptions& options) {
  constexpr int kSteps = 64;  // of a turn
  const double wanted = 2.0 * std::numbers::pi * (i + 0.25) / high;
  for (int step = 0; step <= kSteps; ++step) {
    const int side = step % 2 == 0 ? step / 2 : -(step + 1) / 2;
    const auto centre = high_up(wanted + 2.0 * std::numbers::pi * side / kSteps, options);
    if (!is_behind_a_lamp(centre)) return centre;
  }
  return high_up(wanted, options);
}

// The longest focal length, to half a percent, that still has the volume in the picture.
void fit_lens(capture::CameraModel& camera, const Eigen::AlignedBox3d& volume) {
  constexpr int kSteps = 1400;  // down to a thousandth: a camera within the volume
  for (int step = 0; step < kSteps && !holds(camera, volume); ++step) {
    camera.K(0, 0) *= 0.995;
    camera.K(1, 1) *= 0.995;
  }
  if (!holds(camera, volume))
    throw InvalidInput(fmt::format("{} stands too near to see the whole stage; set a larger radius", camera.name));
}

}  // namespace

bool holds(const capture::CameraModel& camera, const Eigen::AlignedBox3d& volume) {
  constexpr double kRim = 1.0;  // pixels
  for (int corner = 0; corner < 8; ++corner) {
    const auto seen = capture::project(camera, volume.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
    if (!seen || (seen->array() < kRim).any() || seen->x() > camera.width - 1 - kRim ||
        seen->y() > camera.height - 1 - kRim)
      return false;
  }
  return true;
}

LayoutOptions travelling_layout(LayoutOptions options) {
  options.radius = 6.0;
  options.ring_height = 1.05;
  options.aim_height = 1.0;
  options.whole_volume = true;
  return options;
}

capture::CameraModel look_at(const Eigen::Vector3d& centre, const Eigen::Vector3d& target, int width, int height,
                             double fx, double fy) {
  capture::CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.K << fx, 0.0, (width - 1) / 2.0, 0.0, fy, (height - 1) / 2.0, 0.0, 0.0, 1.0;
  const Eigen::Vector3d forward = (target - centre).normalized();
  const Eigen::Vector3d up = std::abs(forward.z()) < 0.999 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  camera.R.row(0) = right;
  camera.R.row(1) = forward.cross(right);
  camera.R.row(2) = forward;
  camera.t = -camera.R * centre;
  return camera;
}

std::vector<capture::CameraModel> camera_layout(const LayoutOptions& options) {
  if (options.cameras < 2 || options.cameras > 64)
    throw InvalidInput(fmt::format("a simulated studio has 2 to 64 cameras, not {}", options.cameras));
  if (options.width < 16 || options.height < 16)
    throw InvalidInput(fmt::format("a picture of {} x {} pixels is too small", options.width, options.height));
  const int high = options.cameras / 5;
  const int ring = options.cameras - high;
  const Eigen::Vector3d aim(0.0, 0.0, options.aim_height);
  std::vector<capture::CameraModel> cameras;
  for (int i = 0; i < options.cameras; ++i) {
    const bool is_high = i >= ring;
    const Eigen::Vector3d centre =
        is_high ? high_place(i - ring, high, options) : on_ring(2.0 * std::numbers::pi * i / ring, options);
    const double fy = options.height * (centre - aim).norm() / options.subject_height;
    auto camera = look_at(centre, aim, options.width, options.height, fy / options.aspect, fy);
    camera.name = fmt::format("cam{:02}", i);
    camera.K(0, 1) = options.skew_px;
    camera.distortion << options.k1, options.k2, options.p1, options.p2, options.k3;
    if (options.whole_volume) {
      camera.K.topLeftCorner<2, 2>() *= 4.0;  // a long lens to begin with
      camera.K(0, 1) = options.skew_px;
      fit_lens(camera, kStageVolume);
    }
    cameras.push_back(camera);
  }
  return cameras;
}

}  // namespace rotunda::simulator
