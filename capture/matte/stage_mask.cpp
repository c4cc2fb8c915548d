#include "capture/matte/stage_mask.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

constexpr int kStep = 4;  // pixels between rays; what lies between is theirs

// Kay and Kajiya 1986: a ray meets a box where its ways through the three pairs of planes overlap.
bool meets(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  double enters = 0.0, leaves = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(along[axis]) < 1e-12) {
      if (from[axis] < box.min()[axis] || from[axis] > box.max()[axis]) return false;
      continue;
    }
    const double a = (box.min()[axis] - from[axis]) / along[axis], b = (box.max()[axis] - from[axis]) / along[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return enters <= leaves;
}

}  // namespace

cv::Mat stage_mask(const CameraModel& camera, const Eigen::AlignedBox3d& volume, int margin_px) {
  const Eigen::Vector3d centre = camera.centre();
  cv::Mat coarse((camera.height - 1) / kStep + 1, (camera.width - 1) / kStep + 1, CV_8UC1, cv::Scalar(0));
  for (int y = 0; y < coarse.rows; ++y)
    for (int x = 0; x < coarse.cols; ++x) {
      const auto ray = ray_through(camera, {x * kStep, y * kStep});
      // Beyond the lens's valid field nothing is known: it may be.
      if (!ray || meets(volume, centre, *ray)) coarse.at<std::uint8_t>(y, x) = 255;
    }
  const int reach = (margin_px + kStep - 1) / kStep + 1;
  cv::dilate(coarse, coarse, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8UC1));
  cv::Mat mask(camera.height, camera.width, CV_8UC1);
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) mask.at<std::uint8_t>(y, x) = coarse.at<std::uint8_t>(y / kStep, x / kStep);
  return mask;
}

}  // namespace rotunda::capture
