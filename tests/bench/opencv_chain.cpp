#include "tests/bench/opencv_chain.h"

#include <Eigen/Core>
#include <algorithm>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace rotunda::bench {
namespace {

using capture::Board;
using capture::BoardType;
using capture::CameraModel;
using capture::Sighting;

std::vector<capture::FoundCorner> charuco_corners(const cv::Mat& grey, const Board& board) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(capture::dictionary_number(board.dictionary));
  const auto charuco = cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square),
                                                       static_cast<float>(board.marker), dictionary);
  std::vector<int> ids, numbers;
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<cv::Point2f> corners;
  cv::aruco::detectMarkers(grey, dictionary, markers, ids);
  if (ids.empty()) return {};
  cv::aruco::interpolateCornersCharuco(markers, ids, grey, charuco, corners, numbers);
  std::vector<capture::FoundCorner> found;
  for (std::size_t i = 0; i < corners.size(); ++i) found.push_back({numbers[i], {corners[i].x, corners[i].y}, 0.0});
  return found;
}

// `first`: where the first corner truly is.
std::vector<capture::FoundCorner> chessboard_corners(const cv::Mat& grey, const Board& board,
                                                     const std::optional<Eigen::Vector2d>& first) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(grey, {board.columns - 1, board.rows - 1}, corners)) return {};
  cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1}, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3});
  const auto off = [&](const cv::Point2f& corner) { return (Eigen::Vector2d(corner.x, corner.y) - *first).norm(); };
  if (first && off(corners.front()) > off(corners.back())) std::reverse(corners.begin(), corners.end());
  std::vector<capture::FoundCorner> found;
  for (std::size_t i = 0; i < corners.size(); ++i)
    found.push_back({static_cast<int>(i), {corners[i].x, corners[i].y}, 0.0});
  return found;
}

struct CvPoints {
  std::vector<cv::Point3f> on_board;
  std::vector<cv::Point2f> pixels;
};

CvPoints points_of(const capture::Sighting& sighting, const Board& board) {
  const auto positions = capture::corner_positions(board);
  CvPoints points;
  for (const auto& corner : sighting.corners) {
    const Eigen::Vector3f p = positions[static_cast<std::size_t>(corner.corner)].cast<float>();
    points.on_board.emplace_back(p.x(), p.y(), p.z());
    points.pixels.emplace_back(static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y()));
  }
  return points;
}

struct OpenCvCamera {
  cv::Mat K, distortion;
};

OpenCvCamera calibrate_one(const std::vector<capture::Sighting>& sightings, const Board& board, cv::Size size) {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const auto& sighting : sightings) {
    auto points = points_of(sighting, board);
    on_board.push_back(std::move(points.on_board)), pixels.push_back(std::move(points.pixels));
  }
  OpenCvCamera camera;
  cv::calibrateCamera(on_board, pixels, size, camera.K, camera.distortion, cv::noArray(), cv::noArray());
  return camera;
}

// Corners that both saw, moment by moment.
struct Common {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> a, b;
};

Common common_corners(const std::vector<capture::Sighting>& a, const std::vector<capture::Sighting>& b,
                      const Board& board) {
  const auto positions = capture::corner_positions(board);
  Common common;
  for (const auto& one : a)
    for (const auto& other : b) {
      if (one.moment != other.moment) continue;
      std::vector<cv::Point3f> on_board;
      std::vector<cv::Point2f> in_a, in_b;
      for (const auto& x : one.corners)
        for (const auto& y : other.corners) {
          if (x.corner != y.corner) continue;
          const Eigen::Vector3f p = positions[static_cast<std::size_t>(x.corner)].cast<float>();
          on_board.emplace_back(p.x(), p.y(), p.z());
          in_a.emplace_back(static_cast<float>(x.pixel.x()), static_cast<float>(x.pixel.y()));
          in_b.emplace_back(static_cast<float>(y.pixel.x()), static_cast<float>(y.pixel.y()));
        }
      if (on_board.size() < 6) continue;
      common.on_board.push_back(on_board), common.a.push_back(in_a), common.b.push_back(in_b);
    }
  return common;
}

}  // namespace

std::vector<std::vector<Sighting>> opencv_corners(const Scene& scene) {
  const auto first_corner = capture::corner_positions(scene.board).front();
  std::vector<std::vector<Sighting>> all(scene.truth.size());
  for (std::size_t camera = 0; camera < scene.truth.size(); ++camera)
    for (std::size_t moment = 0; moment < scene.poses.size(); ++moment) {
      const auto& grey = scene.grey[camera][moment];
      Sighting sighting{.camera = camera, .moment = moment};
      sighting.corners =
          scene.board.type == BoardType::charuco
              ? charuco_corners(grey, scene.board)
              : chessboard_corners(grey, scene.board,
                                   capture::project(scene.truth[camera], scene.poses[moment] * first_corner));
      if (capture::span_an_area(sighting.corners, scene.board)) all[camera].push_back(std::move(sighting));
    }
  return all;
}

std::vector<CameraModel> opencv_chain(const Scene& scene,
                                      const std::vector<std::vector<capture::Sighting>>& sightings) {
  const cv::Size size(scene.truth[0].width, scene.truth[0].height);
  std::vector<OpenCvCamera> intrinsics;
  for (const auto& own : sightings) intrinsics.push_back(calibrate_one(own, scene.board, size));
  std::vector<CameraModel> cameras = scene.truth;
  std::vector<bool> placed(cameras.size(), false);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cv::cv2eigen(intrinsics[i].K, cameras[i].K);
    for (int k = 0; k < 5; ++k) cameras[i].distortion[k] = intrinsics[i].distortion.at<double>(k);
    cameras[i].R.setIdentity(), cameras[i].t.setZero();
  }
  placed[0] = true;
  for (std::size_t round = 1; round < cameras.size(); ++round) {
    std::size_t from = 0, to = 0, most = 0;
    for (std::size_t a = 0; a < cameras.size(); ++a)
      for (std::size_t b = 0; b < cameras.size(); ++b) {
        if (!placed[a] || placed[b]) continue;
        const std::size_t shared = common_corners(sightings[a], sightings[b], scene.board).on_board.size();
        if (shared > most) most = shared, from = a, to = b;
      }
    if (most == 0) break;
    auto common = common_corners(sightings[from], sightings[to], scene.board);
    cv::Mat R, t, E, F;
    cv::stereoCalibrate(common.on_board, common.a, common.b, intrinsics[from].K, intrinsics[from].distortion,
                        intrinsics[to].K, intrinsics[to].distortion, size, R, t, E, F, cv::CALIB_FIX_INTRINSIC);
    Eigen::Matrix3d rotation;
    Eigen::Vector3d shift;
    cv::cv2eigen(R, rotation), cv::cv2eigen(t, shift);
    cameras[to].R = Eigen::Matrix3d(rotation * cameras[from].R);
    cameras[to].t = rotation * cameras[from].t + shift;
    placed[to] = true;
  }
  return cameras;
}

}  // namespace rotunda::bench
