#include "tests/bench/calibration_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/calibration/calibrate.h"
#include "capture/picture.h"
#include "simulator/people/board_prop.h"
#include "simulator/people/texture_atlas.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/pixel_encoding.h"
#include "simulator/studio/scene_renderer.h"
#include "tests/support/board_scene.h"

namespace rotunda::bench {
namespace {

using capture::Board;
using capture::BoardType;
using capture::CameraModel;

constexpr int kMoments = 60;
constexpr double kTexelsAMetre = 2000.0;

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

// As the rig's cameras send it and calibrate looks at it: a mosaic, its green filled in.
cv::Mat green_as_sent(const simulator::ScenePicture& picture) {
  constexpr auto kFormat = capture::PixelFormat::bayer_rg8;
  const auto& deep = picture.deep;
  cv::Mat green;
  cv::extractChannel(
      capture::to_rgb(capture::make_image(deep.cols, deep.rows, kFormat, simulator::encode_pixels(deep, kFormat))),
      green, 1);
  return green;
}

Scene shown(Scene scene, const simulator::Performance& performance, const std::vector<double>& seconds) {
  const simulator::SceneRenderer studio(performance, scene.truth);
  scene.grey.resize(scene.truth.size());
  for (std::size_t moment = 0; moment < seconds.size(); ++moment) {
    scene.poses.push_back(*performance.board_at(seconds[moment]));
    const auto pictures = studio.pictures(seconds[moment], moment);
    for (std::size_t camera = 0; camera < pictures.size(); ++camera)
      scene.grey[camera].push_back(green_as_sent(pictures[camera]));
  }
  return scene;
}

}  // namespace

Scene show_alone(const std::string& name, const Board& board) {
  return show_alone(name, board, rig());
}

Scene show_alone(const std::string& name, const Board& board, const std::vector<CameraModel>& cameras) {
  const BoardShow show(figure_of(board), tests::board_walk(kMoments));
  std::vector<double> seconds;
  for (int i = 0; i < kMoments; ++i) seconds.push_back(i * simulator::kActStep);
  return shown({.name = name, .board = board, .truth = cameras}, show, seconds);
}

Scene show_carried() {
  return show_carried(rig());
}

Scene show_carried(const std::vector<CameraModel>& cameras) {
  const auto performance = simulator::make_performance({.person = "alex", .act = "board"});
  std::vector<double> seconds;
  for (int i = 0; i < kMoments; ++i)
    seconds.push_back(i * (simulator::kBoardLaidSeconds + 2.5) / (kMoments - 1));  // the last lie on the floor
  const simulator::CharucoPattern pattern;
  const Board board{.square = pattern.square, .marker = pattern.marker};
  return shown({.name = "carried", .board = board, .truth = cameras}, *performance, seconds);
}

capture::CalibrationResult calibrated(const Scene& scene) {
  capture::BoardPictures pictures;
  for (const auto& camera : scene.truth) pictures.cameras.push_back(camera.name);
  for (std::size_t i = 0; i < scene.poses.size(); ++i) pictures.moments.push_back(fmt::format("moment{:02}", i));
  pictures.grey = [&](std::size_t camera, std::size_t moment) { return scene.grey[camera][moment]; };
  capture::CalibrateOptions options;
  options.boards = {scene.board};
  return capture::calibrate(pictures, options);
}

}  // namespace rotunda::bench
