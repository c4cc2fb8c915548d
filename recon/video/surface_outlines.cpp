#include "recon/video/surface_outlines.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "recon/sphere/resample.h"

namespace rotunda::recon {
namespace {

constexpr int kCameras = 10;
constexpr int kHeight = 576, kWidth = 720;
constexpr int kLevel = 7;  // of the surface: its triangles are then no larger than a pixel or two

// About `middle`, alternately level with it and from above, so far that a body of this size fills the height.
capture::CameraModel camera_about(const Eigen::Vector3d& middle, double size, int i) {
  constexpr double kFocal = 2.0, kMargin = 1.25;  // picture heights; room around the body
  const double away = kFocal * kMargin * size, turn = 2.0 * std::numbers::pi * i / kCameras;
  const Eigen::Vector3d centre =
      middle + away * Eigen::Vector3d(std::cos(turn), std::sin(turn), i % 2 == 0 ? 0.0 : 0.35).normalized();
  const Eigen::Vector3d forwards = (middle - centre).normalized(),
                        right = forwards.cross(Eigen::Vector3d::UnitZ()).normalized();
  capture::CameraModel camera;
  camera.name = fmt::format("around{:02}", i);
  camera.width = kWidth;
  camera.height = kHeight;
  camera.K << kFocal * kHeight, 0, 0.5 * (kWidth - 1), 0, kFocal * kHeight, 0.5 * (kHeight - 1), 0, 0, 1;
  camera.R.row(0) = right;
  camera.R.row(1) = forwards.cross(right);
  camera.R.row(2) = forwards;
  camera.t = -camera.R * centre;
  return camera;
}

capture::Matte cast_on(const capture::CameraModel& camera, const TriangleMesh& surface) {
  constexpr int kShift = 4, kOne = 1 << kShift;
  std::vector<cv::Point> pixels(surface.positions.size(), {-1, -1});
  for (std::size_t v = 0; v < pixels.size(); ++v)
    if (const auto pixel = capture::project(camera, surface.positions[v].cast<double>()))
      pixels[v] = {static_cast<int>(std::lround(pixel->x() * kOne)), static_cast<int>(std::lround(pixel->y() * kOne))};
  capture::Matte matte{cv::Mat::zeros(camera.height, camera.width, CV_8UC1)};
  for (const auto& t : surface.triangles) {
    const cv::Point corners[] = {pixels[t[0]], pixels[t[1]], pixels[t[2]]};
    cv::fillConvexPoly(matte.alpha, corners, 3, cv::Scalar(255), cv::LINE_8, kShift);
  }
  return matte;
}

}  // namespace

SurfaceOutlines::SurfaceOutlines(const std::filesystem::path& video) : file_(video), video_(video) {}

std::string SurfaceOutlines::where_to_look() const {
  return fmt::format("look at the clip with `rotunda play {}`", file_.string());
}

TriangleMesh SurfaceOutlines::surface(std::size_t frame) {
  const std::lock_guard lock(reading_);
  return remesh(video_.read(static_cast<int>(frame), std::min(kLevel, video_.header().level)));
}

FrameOutlines SurfaceOutlines::outlines(std::size_t frame) {
  const auto surface = clock_.run("read", [&] { return this->surface(frame); });
  return clock_.run("outline", [&] {
    Eigen::AlignedBox3d box;
    for (const auto& position : surface.positions) box.extend(position.cast<double>());
    FrameOutlines result;
    for (int i = 0; i < kCameras; ++i) {
      const auto camera = camera_about(box.center(), box.diagonal().norm(), i);
      result.push_back({camera, silhouette_outline(cast_on(camera, surface))});
    }
    return result;
  });
}

}  // namespace rotunda::recon
