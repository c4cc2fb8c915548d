// How near a calibration from pictures of boards comes to the simulated rig, with all that lenses and sensors of the
// studio get wrong: corners, camera centres and rotations after rigid alignment, projections of points all over the
// volume, time. Beside it OpenCV's own chain (its corners, calibrateCamera, stereoCalibrate from camera to camera) on
// the same pictures, and what the adjustment's covariance expects.
// --pictures: only writes the pictures, board.yaml and truth.yaml to DIR/SCENE, for a measurement of `rotunda calibrate
// --images DIR/SCENE/images` as a whole program.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "capture/calibration/board_detector.h"
#include "capture/calibration/board_sheet.h"
#include "capture/calibration/calibrate.h"
#include "capture/calibration/calibration_covariance.h"
#include "capture/calibration_file.h"
#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "tests/bench/calibration_scene.h"
#include "tests/bench/opencv_chain.h"
#include "tests/bench/own_calibration.h"

namespace rotunda::bench {
namespace {

using capture::CameraModel;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Figures {
  double centre_mean = 0, centre_worst = 0;              // mm
  double rotation_worst = 0;                             // degrees
  double reprojection_mean = 0, reprojection_worst = 0;  // px, over cameras
};

std::vector<Eigen::Vector3d> points_in_volume() {
  std::vector<Eigen::Vector3d> points;
  const auto& box = simulator::kStageVolume;
  for (double x = box.min().x(); x <= box.max().x() + 1e-9; x += 0.25)
    for (double y = box.min().y(); y <= box.max().y() + 1e-9; y += 0.25)
      for (double z = box.min().z(); z <= box.max().z() + 1e-9; z += 0.25) points.emplace_back(x, y, z);
  return points;
}

// Those the true camera has in its picture.
std::vector<Eigen::Vector3d> in_picture(const CameraModel& camera, const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> seen;
  for (const auto& point : points) {
    const auto pixel = capture::project(camera, point);
    if (pixel && pixel->minCoeff() >= 0 && pixel->x() <= camera.width - 1 && pixel->y() <= camera.height - 1)
      seen.push_back(point);
  }
  return seen;
}

Figures figures_of(const std::vector<CameraModel>& found, const std::vector<CameraModel>& truth) {
  const auto aligned = aligned_cameras(found, truth);
  const auto n = static_cast<double>(truth.size());
  Figures figures;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const CameraModel& camera = aligned[i];
    const double off = 1e3 * (camera.centre() - truth[i].centre()).norm();
    figures.centre_mean += off / n;
    figures.centre_worst = std::max(figures.centre_worst, off);
    const double angle = Eigen::AngleAxisd(camera.R * truth[i].R.transpose()).angle() * 180.0 / std::numbers::pi;
    figures.rotation_worst = std::max(figures.rotation_worst, angle);
    double sum = 0.0;
    int count = 0;
    for (const auto& point : in_picture(truth[i], points_in_volume()))
      if (const auto pixel = capture::project(camera, point)) {
        sum += (*pixel - *capture::project(truth[i], point)).norm();
        ++count;
      }
    figures.reprojection_mean += sum / std::max(1, count) / n;
    figures.reprojection_worst = std::max(figures.reprojection_worst, sum / std::max(1, count));
  }
  return figures;
}

// Means of lengths of normally distributed errors: in the plane 0.886, in space 0.921 of their root mean square.
Figures bound_of(const capture::CalibrationResult& result) {
  capture::RigState state;
  state.cameras = result.cameras;
  std::vector<capture::Sighting> sightings;
  for (const auto& pose : result.poses) state.world_from_board[{pose.moment, pose.board}] = pose.world_from_board;
  for (const auto& view : result.views) {
    capture::Sighting sighting{.camera = view.camera, .moment = view.moment, .board = view.board};
    for (const auto& corner : view.corners)
      if (!corner.outlier) sighting.corners.push_back({corner.corner, corner.pixel, 0.0});
    sightings.push_back(std::move(sighting));
  }
  const auto covariance = capture::camera_covariance(state, sightings, result.boards, {}, result.corner_noise_px);
  Figures bound;
  const auto n = static_cast<double>(result.cameras.size());
  for (std::size_t i = 0; i < result.cameras.size(); ++i) {
    const auto deviation = capture::deviation_of(covariance, i);
    bound.centre_mean += 0.921e3 * deviation.centre / n;
    bound.centre_worst = std::max(bound.centre_worst, 1e3 * deviation.centre);
    bound.rotation_worst = std::max(bound.rotation_worst, deviation.rotation_deg);
    std::vector<Eigen::Vector3d> points;
    // The points of the volume as the result's own world has them are near enough to those of truth.
    for (const auto& point : in_picture(result.cameras[i], points_in_volume())) points.push_back(point);
    const double off = 0.886 * capture::expected_reprojection(covariance, state, i, points);
    bound.reprojection_mean += off / n;
    bound.reprojection_worst = std::max(bound.reprojection_worst, off);
  }
  return bound;
}

struct CornerErrors {
  double mean = 0, p95 = 0;
  std::size_t corners = 0;
};

CornerErrors corner_errors(const std::vector<capture::Sighting>& sightings, const Scene& scene) {
  const auto positions = capture::corner_positions(scene.board);
  std::vector<double> all;
  for (const auto& sighting : sightings)
    for (const auto& corner : sighting.corners)
      if (const auto pixel =
              capture::project(scene.truth[sighting.camera],
                               scene.poses[sighting.moment] * positions[static_cast<std::size_t>(corner.corner)]))
        all.push_back((corner.pixel - *pixel).norm());
  std::sort(all.begin(), all.end());
  CornerErrors errors{.corners = all.size()};
  for (const double e : all) errors.mean += e / static_cast<double>(all.size());
  if (!all.empty()) errors.p95 = all[all.size() * 95 / 100];
  return errors;
}

void print(const std::string& name, const std::string& chain, const Figures& f) {
  fmt::print("{:11} {:10} centres {:6.2f} / {:6.2f} mm  rotation {:.4f} deg  reprojection {:.3f} / {:.3f} px\n", name,
             chain, f.centre_mean, f.centre_worst, f.rotation_worst, f.reprojection_mean, f.reprojection_worst);
}

void print(const std::string& name, const std::string& chain, const CornerErrors& errors) {
  fmt::print("{:11} {:10} corners mean {:.3f} p95 {:.3f} px, {} found\n", name, chain, errors.mean, errors.p95,
             errors.corners);
}

std::vector<capture::Sighting> flat(const std::vector<std::vector<capture::Sighting>>& by_camera) {
  std::vector<capture::Sighting> all;
  for (const auto& own : by_camera) all.insert(all.end(), own.begin(), own.end());
  return all;
}

std::vector<capture::Sighting> used_corners(const capture::CalibrationResult& result) {
  std::vector<capture::Sighting> used;
  for (const auto& view : result.views) {
    auto& sighting = used.emplace_back(capture::Sighting{.camera = view.camera, .moment = view.moment});
    for (const auto& corner : view.corners)
      if (!corner.outlier) sighting.corners.push_back({corner.corner, corner.pixel, 0.0});
  }
  return used;
}

std::vector<capture::Sighting> detected(const Scene& scene) {
  const capture::BoardDetector detector({scene.board});
  std::vector<capture::Sighting> all;
  for (std::size_t camera = 0; camera < scene.truth.size(); ++camera)
    for (std::size_t moment = 0; moment < scene.poses.size(); moment += 4)
      for (auto& board : detector.detect(scene.grey[camera][moment]))
        all.push_back({.camera = camera, .moment = moment, .corners = std::move(board.corners)});
  return all;
}

void measure(const Scene& scene) {
  const auto begun = std::chrono::steady_clock::now();
  const double cpu = cpu_seconds();
  const auto result = calibrated(scene);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  print(scene.name, "detector", corner_errors(detected(scene), scene));
  print(scene.name, "used", corner_errors(used_corners(result), scene));
  if (result.cameras.size() == scene.truth.size()) {
    print(scene.name, "rotunda", figures_of(result.cameras, scene.truth));
    print(scene.name, "bound", bound_of(result));
  }
  fmt::print(
      "{:11} {:10} wall {:.1f} s, CPU {:.1f} s; noise {:.3f} px, held out {:.3f} px rms, verdict {}, world: {}\n",
      scene.name, "rotunda", wall, cpu_seconds() - cpu, result.corner_noise_px, result.held_out_rms_px,
      to_string(result.verdict), result.world);
  for (const auto& problem : result.problems) fmt::print("  {}\n", problem);
  for (const auto& quality : result.quality)
    for (const auto& advice : quality.advice) fmt::print("  {}\n", advice);
  const double opencv_cpu = cpu_seconds();
  const auto corners = opencv_corners(scene);
  print(scene.name, "OpenCV", corner_errors(flat(corners), scene));
  print(scene.name, "OpenCV", figures_of(opencv_chain(scene, corners), scene.truth));
  fmt::print("{:11} {:10} CPU {:.1f} s\n", scene.name, "OpenCV", cpu_seconds() - opencv_cpu);
}

void write_pictures(const Scene& scene, const std::filesystem::path& folder) {
  for (std::size_t camera = 0; camera < scene.truth.size(); ++camera) {
    const auto own = folder / "images" / scene.truth[camera].name;
    std::filesystem::create_directories(own);
    for (std::size_t moment = 0; moment < scene.poses.size(); ++moment)
      cv::imwrite((own / fmt::format("moment{:02}.png", moment)).string(), scene.grey[camera][moment]);
  }
  std::ofstream(folder / "board.yaml") << capture::board_yaml(std::span(&scene.board, 1));
  capture::write_calibration(folder / "truth.yaml", scene.truth);
}

Scene scene_called(const std::string& name) {
  using capture::BoardType;
  if (name == "charuco") return show_alone(name, {});
  if (name == "chessboard")
    return show_alone(name, {.type = BoardType::chessboard, .columns = 10, .rows = 7, .square = 0.1, .marker = 0.0});
  if (name == "carried") return show_carried();
  throw InvalidInput("there is no scene called " + name + ": charuco, chessboard or carried");
}

}  // namespace
}  // namespace rotunda::bench

int main(int argc, char** argv) {
  using namespace rotunda::bench;
  CLI::App app("Calibration of rendered boards against the true rig, beside OpenCV's chain");
  std::vector<std::string> scenes{"charuco", "chessboard", "carried"};
  std::filesystem::path pictures;
  app.add_option("SCENE", scenes, "charuco, chessboard, carried")->capture_default_str();
  app.add_option("--pictures", pictures, "write the scenes' pictures there instead of calibrating");
  CLI11_PARSE(app, argc, argv);
  for (const auto& name : scenes) {
    const auto scene = scene_called(name);
    if (pictures.empty())
      measure(scene);
    else
      write_pictures(scene, pictures / name);
  }
}
