#include "tests/bench/own_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "capture/calibration_file.h"
#include "config/errors.h"
#include "tests/bench/calibration_scene.h"

namespace rotunda::bench {
namespace {

using capture::Board;
using capture::CameraModel;

bool is_whole(const capture::CalibrationResult& result, const std::vector<CameraModel>& truth) {
  return result.cameras.size() == truth.size() && std::all_of(result.quality.begin(), result.quality.end(),
                                                              [](const auto& q) { return q.corners > q.outliers; });
}

// As an operator does: to a camera that stands too far off for the studio's board a larger one is shown.
std::vector<CameraModel> all_calibrated(const std::vector<CameraModel>& truth) {
  auto result = calibrated(show_carried(truth));
  if (!is_whole(result, truth)) result = calibrated(show_alone("large", Board{}, truth));
  if (!is_whole(result, truth))
    throw InvalidInput(fmt::format("{} of {} cameras could be calibrated: {}", result.cameras.size(), truth.size(),
                                   fmt::join(result.problems, "; ")));
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
  const auto cameras = aligned_cameras(all_calibrated(truth), truth);
  if (!keep.empty()) {
    std::filesystem::create_directories(keep);
    capture::write_calibration(file, cameras);
  }
  return cameras;
}

}  // namespace rotunda::bench
