// How near a calibration from pictures of boards comes to the simulated rig, with all that lenses and sensors of the
// studio get wrong: corners, camera centres and rotations after rigid alignment, projections of points all over the
// volume, time. Beside it OpenCV's own chain (its corners, calibrateCamera, stereoCalibrate from camera to camera) on
// the same pictures, and what the adjustment's covariance expects.
// usage: calibration_bench [charuco|chessboard|carried ...]
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/calibration/board_detector.h"
#include "capture/calibration/calibrate.h"
#include "capture/calibration/calibration_covariance.h"
#include "simulator/people/board_prop.h"
#include "simulator/people/texture_atlas.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/scene_renderer.h"
#include "tests/support/board_scene.h"

namespace rotunda {
namespace {

using capture::Board;
using capture::BoardType;
using capture::CameraModel;

constexpr int kMoments = 60;
constexpr double kTexelsAMetre = 2000.0;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// A board alone, held still at each of its moments: act frame i shows pose i.
class BoardShow : public simulator::Performance {
 public:
  BoardShow(simulator::Figure figure, std::vector<Eigen::Isometry3d> poses)
      : figures_{std::move(figure)}, poses_(std::move(poses)) {}
  const std::string& person() const override { return name_; }
  const std::string& act() const override { return name_; }
  int frames() const override { return static_cast<int>(poses_.size()); }
  bool is_cyclic() const override { return true; }
  const std::vector<simulator::Figure>& figures() const override { return figures_; }
  std::vector<recon::TriangleMesh> surfaces_at(double seconds) const override {
    return {simulator::carried(figures_.front().bind, *board_at(seconds))};
  }
  const std::vector<simulator::JointInfo>& joints() const override { return joints_; }
  std::vector<simulator::JointState> joints_at(double) const override { return {}; }
  std::vector<simulator::HeelStrike> heel_strikes() const override { return {}; }
  std::optional<Eigen::Isometry3d> board_at(double seconds) const override {
    const auto n = static_cast<long>(poses_.size());
    return poses_[static_cast<std::size_t>(((std::lround(seconds / simulator::kActStep) % n) + n) % n)];
  }
  std::string fingerprint() const override { return name_; }

 private:
  std::string name_ = "board";
  std::vector<simulator::Figure> figures_;
  std::vector<simulator::JointInfo> joints_;
  std::vector<Eigen::Isometry3d> poses_;
};

simulator::CarriedBoard plate_of(const Board& board) {
  simulator::CarriedBoard plate;
  plate.width = board.columns * board.square + 0.06;
  plate.height = board.rows * board.square + 0.06;
  return plate;
}

// The chessboard printed over the face of a plate made for a ChArUco board of the same size.
simulator::Figure chessboard_figure(const Board& board) {
  const auto plate = plate_of(board);
  auto figure = simulator::board_figure(plate, {.columns = 2, .rows = 2, .square = 0.1, .marker = 0.08});
  const auto texels = [](double metres) { return static_cast<int>(std::lround(metres * kTexelsAMetre)); };
  const cv::Scalar ink = cv::Scalar::all(56), paper = cv::Scalar::all(237);
  cv::Mat face(texels(plate.height), texels(plate.width), CV_8UC3, paper);
  for (const auto& box : capture::black_rectangles(board))
    face(cv::Rect(cv::Point(texels(box.min().x() + plate.width / 2), texels(plate.height / 2 - box.max().y())),
                  cv::Point(texels(box.max().x() + plate.width / 2), texels(plate.height / 2 - box.min().y()))))
        .setTo(ink);
  const auto atlas = simulator::pack_pictures({face, cv::Mat(8, 8, CV_8UC3, paper)});
  figure.texture.picture = atlas.picture;
  figure.texture.corners.clear();
  for (const auto& triangle : figure.bind.triangles) {
    const bool is_face =
        std::all_of(triangle.begin(), triangle.end(), [&](auto v) { return figure.bind.normals[v].z() > 0.0F; });
    for (const auto v : triangle) {
      const auto& p = figure.bind.positions[v];
      const Eigen::Vector2f texel(static_cast<float>(kTexelsAMetre * (p.x() + 0.5 * plate.width)),
                                  static_cast<float>(kTexelsAMetre * (0.5 * plate.height - p.y())));
      figure.texture.corners.push_back(is_face ? atlas.at(0, texel) : atlas.at(1, {4.0F, 4.0F}));
    }
  }
  return figure;
}

simulator::Figure figure_of(const Board& board) {
  if (board.type == BoardType::chessboard) return chessboard_figure(board);
  return simulator::board_figure(plate_of(board), {.columns = board.columns,
                                                   .rows = board.rows,
                                                   .square = board.square,
                                                   .marker = board.marker,
                                                   .dictionary = board.dictionary});
}

std::vector<CameraModel> rig() {
  return simulator::camera_layout({.k1 = -0.18, .k2 = 0.06, .p1 = 0.0004, .p2 = -0.0003});
}

struct Scene {
  std::string name;
  Board board;
  std::vector<CameraModel> truth;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<std::vector<cv::Mat>> grey;  // by camera, then moment
};

Scene shown(std::string name, const Board& board, const simulator::Performance& performance,
            const std::vector<double>& seconds) {
  Scene scene{.name = std::move(name), .board = board, .truth = rig()};
  const simulator::SceneRenderer studio(performance, scene.truth);
  scene.grey.resize(scene.truth.size());
  for (std::size_t moment = 0; moment < seconds.size(); ++moment) {
    scene.poses.push_back(*performance.board_at(seconds[moment]));
    const auto pictures = studio.pictures(seconds[moment], moment);
    for (std::size_t camera = 0; camera < pictures.size(); ++camera) {
      cv::extractChannel(pictures[camera].rgb, scene.grey[camera].emplace_back(), 1);
    }
  }
  return scene;
}

Scene show_alone(const std::string& name, const Board& board) {
  const BoardShow show(figure_of(board), tests::board_walk(kMoments));
  std::vector<double> seconds;
  for (int i = 0; i < kMoments; ++i) seconds.push_back(i * simulator::kActStep);
  return shown(name, board, show, seconds);
}

Scene show_carried() {
  const auto performance = simulator::make_performance({.person = "alex", .act = "board"});
  std::vector<double> seconds;
  for (int i = 0; i < kMoments; ++i)
    seconds.push_back(i * (simulator::kBoardLaidSeconds + 2.5) / (kMoments - 1));  // the last lie on the floor
  const simulator::CharucoPattern pattern;
  return shown("carried", {.square = pattern.square, .marker = pattern.marker}, *performance, seconds);
}

// --- OpenCV's own chain
// -----------------------------------------------------------------------------------------------

std::vector<std::vector<capture::Sighting>> opencv_corners(const Scene& scene) {
  std::vector<std::vector<capture::Sighting>> all(scene.truth.size());
  const auto& board = scene.board;
  cv::Ptr<cv::aruco::CharucoBoard> charuco;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  if (board.type == BoardType::charuco) {
    dictionary = cv::aruco::getPredefinedDictionary(capture::dictionary_number(board.dictionary));
    charuco = cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square),
                                              static_cast<float>(board.marker), dictionary);
  }
  for (std::size_t camera = 0; camera < scene.truth.size(); ++camera)
    for (std::size_t moment = 0; moment < scene.poses.size(); ++moment) {
      const auto& grey = scene.grey[camera][moment];
      capture::Sighting sighting{.camera = camera, .moment = moment};
      if (charuco) {
        std::vector<int> ids, corner_ids;
        std::vector<std::vector<cv::Point2f>> markers;
        std::vector<cv::Point2f> corners;
        cv::aruco::detectMarkers(grey, dictionary, markers, ids);
        if (ids.empty()) continue;
        cv::aruco::interpolateCornersCharuco(markers, ids, grey, charuco, corners, corner_ids);
        for (std::size_t i = 0; i < corners.size(); ++i)
          sighting.corners.push_back({corner_ids[i], {corners[i].x, corners[i].y}, 0.0});
      } else {
        std::vector<cv::Point2f> corners;
        if (!cv::findChessboardCorners(grey, {board.columns - 1, board.rows - 1}, corners)) continue;
        cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1}, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3});
        // OpenCV lists a grid from either end: told from truth here, so that the chain has only its own errors.
        const auto positions = capture::corner_positions(board);
        const auto first = capture::project(scene.truth[camera], scene.poses[moment] * positions.front());
        if (first &&
            cv::norm(corners.front() - cv::Point2f(static_cast<float>(first->x()), static_cast<float>(first->y()))) >
                cv::norm(corners.back() - cv::Point2f(static_cast<float>(first->x()), static_cast<float>(first->y()))))
          std::reverse(corners.begin(), corners.end());
        for (std::size_t i = 0; i < corners.size(); ++i)
          sighting.corners.push_back({static_cast<int>(i), {corners[i].x, corners[i].y}, 0.0});
      }
      if (capture::span_an_area(sighting.corners, board)) all[camera].push_back(std::move(sighting));
    }
  return all;
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

// Each camera by itself, then the next nearest by shared boards to one that stands (Prim), pair by pair.
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

// --- figures
// ----------------------------------------------------------------------------------------------------------

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
  const auto n = static_cast<Eigen::Index>(truth.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = found[static_cast<std::size_t>(i)].centre();
    b.col(i) = truth[static_cast<std::size_t>(i)].centre();
  }
  const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
  const Eigen::Matrix3d turn = T.topLeftCorner<3, 3>();
  const Eigen::Vector3d shift = T.topRightCorner<3, 1>();
  Figures figures;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    CameraModel camera = found[i];
    camera.R = Eigen::Matrix3d(found[i].R * turn.transpose());
    camera.t = found[i].t - camera.R * shift;
    const double off = 1e3 * (camera.centre() - truth[i].centre()).norm();
    figures.centre_mean += off / static_cast<double>(n);
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
    figures.reprojection_mean += sum / std::max(1, count) / static_cast<double>(n);
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
  capture::BoardPictures pictures;
  for (const auto& camera : scene.truth) pictures.cameras.push_back(camera.name);
  for (std::size_t i = 0; i < scene.poses.size(); ++i) pictures.moments.push_back(fmt::format("moment{:02}", i));
  pictures.grey = [&](std::size_t camera, std::size_t moment) { return scene.grey[camera][moment]; };
  capture::CalibrateOptions options;
  options.boards = {scene.board};
  const auto begun = std::chrono::steady_clock::now();
  const double cpu = cpu_seconds();
  const auto result = capture::calibrate(pictures, options);
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
  const double opencv_cpu = cpu_seconds();
  const auto corners = opencv_corners(scene);
  print(scene.name, "OpenCV", corner_errors(flat(corners), scene));
  print(scene.name, "OpenCV", figures_of(opencv_chain(scene, corners), scene.truth));
  fmt::print("{:11} {:10} CPU {:.1f} s\n", scene.name, "OpenCV", cpu_seconds() - opencv_cpu);
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  using namespace rotunda;
  std::vector<std::string> scenes(argv + 1, argv + argc);
  if (scenes.empty()) scenes = {"charuco", "chessboard", "carried"};
  for (const auto& scene : scenes) {
    if (scene == "charuco") measure(show_alone(scene, {}));
    if (scene == "chessboard")
      measure(
          show_alone(scene, {.type = BoardType::chessboard, .columns = 10, .rows = 7, .square = 0.1, .marker = 0.0}));
    if (scene == "carried") measure(show_carried());
  }
}
