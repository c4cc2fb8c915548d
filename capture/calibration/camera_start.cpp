#include "capture/calibration/camera_start.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

namespace rotunda::capture {
namespace {

constexpr std::size_t kMostViews = 24;                      // of a first calibration; the adjustment of all uses all
constexpr double kSettled = 1.0;                            // pixels of noise: the closed form was right
constexpr std::array kFocalLengths = {0.6, 1.0, 1.8, 3.5};  // of the picture's longer side, where it was not

struct Points {
  std::vector<cv::Point3f> on_board;
  std::vector<cv::Point2f> pixels;
};

Points points_of(const Sighting& sighting, const Board& board) {
  const auto positions = corner_positions(board);
  Points points;
  for (const auto& corner : sighting.corners) {
    const Eigen::Vector3f at = positions[static_cast<std::size_t>(corner.corner)].cast<float>();
    points.on_board.emplace_back(at.x(), at.y(), at.z());
    points.pixels.emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
  }
  return points;
}

// The views with the most corners, spread over all.
std::vector<Sighting> a_few(std::span<const Sighting> sightings) {
  std::vector<Sighting> few(sightings.begin(), sightings.end());
  std::stable_sort(few.begin(), few.end(),
                   [](const auto& a, const auto& b) { return a.corners.size() > b.corners.size(); });
  few.resize(std::min(few.size(), 2 * kMostViews));
  std::vector<Sighting> spread;
  const std::size_t step = few.size() > kMostViews ? 2 : 1;
  for (std::size_t i = 0; i < few.size(); i += step) spread.push_back(few[i]);
  return spread;
}

double closed_form(const CameraModel& camera, std::span<const Sighting> sightings, std::span<const Board> boards) {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const auto& sighting : sightings) {
    auto points = points_of(sighting, boards[sighting.board]);
    on_board.push_back(std::move(points.on_board));
    pixels.push_back(std::move(points.pixels));
  }
  const cv::Mat K = cv::initCameraMatrix2D(on_board, pixels, {camera.width, camera.height}, 1.0);
  const double f = K.at<double>(0, 0), longer = std::max(camera.width, camera.height);
  return f > 0.2 * longer && f < 20.0 * longer ? f : 1.2 * longer;
}

CameraModel pinhole(CameraModel camera, double f) {
  camera.K << f, 0, 0.5 * (camera.width - 1), 0, f, 0.5 * (camera.height - 1), 0, 0, 1;
  camera.distortion.setZero();
  camera.R.setIdentity();
  camera.t.setZero();
  return camera;
}

// `second`: bit i says that of the two poses of view i the second is meant.
std::optional<CameraStart> adjusted(const CameraModel& start, std::span<const Sighting> sightings,
                                    std::span<const Board> boards, std::size_t fewest, unsigned second = 0) {
  RigState state;
  state.cameras = {start};
  std::vector<Sighting> own;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    Sighting sighting = sightings[i];
    const auto poses = camera_from_board(start, sighting, boards[sighting.board]);
    if (poses.empty()) continue;
    sighting.camera = 0;
    const bool is_second = i < kFewestViews && (second >> i & 1U) != 0;
    state.world_from_board[{sighting.moment, sighting.board}] = is_second ? poses.back() : poses.front();
    own.push_back(std::move(sighting));
  }
  if (own.size() < fewest) return std::nullopt;
  const auto report = adjust(state, own, boards, {.rounds = 4});
  return CameraStart{state.cameras.front(), report.noise_px};
}

}  // namespace

std::vector<Eigen::Isometry3d> camera_from_board(const CameraModel& camera, const Sighting& sighting,
                                                 const Board& board) {
  const auto positions = corner_positions(board);
  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> ideal;
  const Eigen::Matrix3d K_inverse = camera.K.inverse();
  for (const auto& corner : sighting.corners) {
    const auto at = undistort(camera, (K_inverse * corner.pixel.homogeneous()).hnormalized());
    if (!at) continue;
    const auto& p = positions[static_cast<std::size_t>(corner.corner)];
    on_board.emplace_back(p.x(), p.y(), p.z());
    ideal.emplace_back(at->x(), at->y());
  }
  if (on_board.size() < 4) return {};
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(on_board, ideal, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                      cv::SOLVEPNP_IPPE);
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    cv::Mat R;
    cv::Rodrigues(rotations[i], R);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Eigen::Matrix3d rotation;
    cv::cv2eigen(R, rotation);
    pose.linear() = rotation;
    pose.translation() = Eigen::Map<const Eigen::Vector3d>(translations[i].ptr<double>());
    if (pose.translation().z() > 0.0 && pose.matrix().allFinite()) poses.push_back(pose);
  }
  return poses;
}

std::optional<CameraStart> start_camera(const CameraModel& camera, std::span<const Sighting> sightings,
                                        std::span<const Board> boards, std::size_t fewest) {
  if (sightings.size() < fewest) return std::nullopt;
  const auto few = a_few(sightings);
  auto best = adjusted(pinhole(camera, closed_form(camera, few, boards)), few, boards, fewest);
  if (best && best->noise_px < kSettled && sightings.size() >= kFewestViews) return best;
  // Few views bear with a wrong one of a plane's two poses, and a focal length to suit it.
  const unsigned choices = few.size() < kFewestViews ? 1U << few.size() : 1U;
  for (const double share : kFocalLengths)
    for (unsigned second = 0; second < choices; ++second) {
      const auto other =
          adjusted(pinhole(camera, share * std::max(camera.width, camera.height)), few, boards, fewest, second);
      if (other && (!best || other->noise_px < best->noise_px)) best = other;
    }
  return best;
}

}  // namespace rotunda::capture
