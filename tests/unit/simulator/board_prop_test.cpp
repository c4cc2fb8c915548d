#include "simulator/people/board_prop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"
#include "simulator/studio/scene_renderer.h"

namespace rotunda::simulator {
namespace {

// Nobody, only the board on its path.
class FlyingBoard : public Performance {
 public:
  const std::string& person() const override { return name_; }
  const std::string& act() const override { return name_; }
  int frames() const override { return kBoardActFrames; }
  bool is_cyclic() const override { return false; }
  const std::vector<Figure>& figures() const override { return figures_; }
  std::vector<recon::TriangleMesh> surfaces_at(double seconds) const override {
    return {carried(figures_[0].bind, board_pose(seconds))};
  }
  const std::vector<JointInfo>& joints() const override { return joints_; }
  std::vector<JointState> joints_at(double) const override { return {}; }
  std::vector<HeelStrike> heel_strikes() const override { return {}; }
  std::string fingerprint() const override { return "board"; }

 private:
  std::string name_ = "board";
  std::vector<Figure> figures_ = {board_figure()};
  std::vector<JointInfo> joints_;
};

// Distances of the corners OpenCV finds from where they truly are, pixels.
std::vector<double> errors_in(const cv::Mat& rgb, const capture::CameraModel& camera, const Eigen::Isometry3d& pose) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  const auto board = cv::aruco::CharucoBoard::create(6, 4, 0.100F, 0.075F, dictionary);
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<cv::Point2f> corners;
  std::vector<int> marker_ids, ids;
  cv::aruco::detectMarkers(grey, dictionary, markers, marker_ids);
  if (marker_ids.empty()) return {};
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, grey, board, corners, ids);
  const auto truth = board_corners();
  std::vector<double> errors;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto pixel = capture::project(camera, pose * truth.at(static_cast<std::size_t>(ids[i])));
    // OpenCV's aruco counts from the corner of the first pixel, all else from its centre.
    const Eigen::Vector2d found(corners[i].x - 0.5F, corners[i].y - 0.5F);
    if (pixel) errors.push_back((*pixel - found).norm());
  }
  return errors;
}

TEST(BoardProp, IsAClosedPlateWithItsPatternTheRightWayUp) {
  const auto figure = board_figure();
  EXPECT_TRUE(recon::topology_of(figure.bind).is_sphere());
  EXPECT_NEAR(recon::signed_volume(figure.bind), 0.66 * 0.46 * 0.010, 1e-6);
  EXPECT_EQ(figure.texture.corners.size(), 3 * figure.bind.triangles.size());
  EXPECT_EQ(board_corners().size(), 15U);
  EXPECT_TRUE(board_corners().front().isApprox(Eigen::Vector3d(-0.2, 0.1, 0.0)));
  EXPECT_EQ(board_yaml(), "type: charuco\nsquares: [6, 4]\nsquare_mm: 100\nmarker_mm: 75\ndictionary: DICT_4X4_50\n");
  EXPECT_THROW(board_figure({}, {.columns = 8}), InvalidInput);
  EXPECT_THROW(board_figure({.width = 2.0, .height = 2.0}, {.columns = 12, .rows = 12}), InvalidInput);
  EXPECT_THROW(board_figure({}, {.dictionary = "DICT_0X0"}), InvalidInput);
}

// Two cameras as dense as 2448 x 2048 on the stage, cut to the board, look at it askew through noise, vignetting and a
// bent lens. The projected truth is exact; what is left is the detector's.
TEST(BoardProp, IsDetectedWhereItTrulyIs) {
  const FlyingBoard flying;
  const double seconds = kBoardLaidSeconds + 1.0;  // at rest: an open shutter blurs nothing
  const auto pose = board_pose(seconds);
  std::vector<capture::CameraModel> cameras;
  for (const Eigen::Vector3d& from : {Eigen::Vector3d(0.3, 0.2, 2.5), Eigen::Vector3d(-1.2, 0.3, 2.2)}) {
    cameras.push_back(look_at(pose * from, pose.translation(), 480, 400, 1300.0, 1300.0));
    cameras.back().distortion[0] = -0.08;
  }
  SceneRenderer studio(flying, cameras);
  std::vector<double> errors;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const auto found = errors_in(studio.picture(camera, seconds, 0).rgb, cameras[camera], pose);
    EXPECT_GE(found.size(), 12U) << camera;
    errors.insert(errors.end(), found.begin(), found.end());
  }
  ASSERT_FALSE(errors.empty());
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.3);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.6);
}

}  // namespace
}  // namespace rotunda::simulator
