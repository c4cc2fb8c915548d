#include "tests/bench/own_calibration.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "capture/calibration/calibrate.h"
#include "capture/calibration_file.h"
#include "config/errors.h"
#include "tests/bench/calibration_scene.h"

namespace rotunda::bench {
namespace {

using capture::CameraModel;

std::vector<CameraModel> calibrated(const Scene& scene) {
  capture::BoardPictures pictures;
  for (const auto& camera : scene.truth) pictures.cameras.push_back(camera.name);
  for (std::size_t i = 0; i < scene.poses.size(); ++i) pictures.moments.push_back(fmt::format("moment{:02}", i));
  pictures.grey = [&](std::size_t camera, std::size_t moment) { return scene.grey[camera][moment]; };
  capture::CalibrateOptions options;
  options.boards = {scene.board};
  auto result = capture::calibrate(pictures, options);
  if (result.cameras.size() != scene.truth.size())
    throw InvalidInput(fmt::format("{} of {} cameras could be calibrated", result.cameras.size(), scene.truth.size()));
  return std::move(result.cameras);
}

}  // namespace

std::vector<CameraModel> aligned_cameras(std::vector<CameraModel> found, const std::vector<CameraModel>& truth) {
  const auto n = static_cast<Eigen::Index>(truth.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = found[static_cast<std::size_t>(i)].centre();
    b.col(i) = truth[static_cast<std::size_t>(i)].centre();
  }
  const Eigen::Matrix4d move = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3d turn = move.topLeftCorner<3, 3>();
  const Eigen::Vector3d shift = move.topRightCorner<3, 1>();
  for (auto& camera : found) {
    camera.R = Eigen::Matrix3d(camera.R * turn.transpose());
    camera.t -= camera.R * shift;
  }
  return found;
}

std::vector<CameraModel> own_calibration(const std::string& rig, const std::vector<CameraModel>& truth,
                                         const std::filesystem::path& keep) {
  const auto file = keep / fmt::format("{}.own-calibration.yaml", rig);
  if (!keep.empty() && std::filesystem::exists(file)) return capture::read_calibration(file);
  const auto cameras = aligned_cameras(calibrated(show_carried(truth)), truth);
  if (!keep.empty()) {
    std::filesystem::create_directories(keep);
    capture::write_calibration(file, cameras);
  }
  return cameras;
}

}  // namespace rotunda::bench
