#include "capture/calibration/board_colours.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "capture/picture.h"
#include "capture/srgb.h"
#include "config/errors.h"
#include "take_fixture.h"
#include "tests/support/board_scene.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const Board kBoard{.type = BoardType::chessboard, .columns = 6, .rows = 5, .square = 0.18, .marker = 0.0};

// What a camera of these gains (linear light) makes of a board of grey and white.
cv::Mat coloured(const cv::Mat& grey, const Eigen::Vector3d& gains) {
  cv::Mat rgb;
  cv::cvtColor(grey, rgb, cv::COLOR_GRAY2RGB);
  return with_matrix(rgb, Eigen::Matrix3d(gains.asDiagonal()));
}

TEST(BoardColours, TheWhiteOfABoardTellsEveryCamerasGains) {
  auto rig = tests::board_rig(8, 320, 256, 330.0);
  rig.resize(2);  // neighbours
  const BoardPrint print(kBoard);
  const std::vector<Eigen::Vector3d> gains = {{1.15, 0.95, 0.85}, {0.9, 1.05, 1.1}};
  const test::TemporaryFolder folder;
  int moments = 0;
  for (const auto& pose : tests::board_walk(40)) {
    if (pose.linear().col(2).x() < 0.8 || moments == 4) continue;
    for (std::size_t camera = 0; camera < rig.size(); ++camera) {
      const auto grey = tests::board_picture(rig[camera], print, pose, {.noise = 1.0, .white = 0.6});
      fs::create_directories(folder.path() / rig[camera].name);
      write_png(folder.path() / rig[camera].name / (std::to_string(moments) + ".png"), coloured(grey, gains[camera]));
    }
    ++moments;
  }
  const auto colours = colours_of_boards(folder.path(), {kBoard});
  EXPECT_GE(colours.pictures, 6U);
  const auto match = match_colours(colours.cameras, colours.samples);
  EXPECT_GT(match.before, 8.0) << "levels";
  EXPECT_LT(match.after, 2.5) << "noise of a level in either, and rounding";
  // Up to the rig's own mean: ratios of cameras.
  for (int channel = 0; channel < 3; ++channel)
    for (std::size_t i = 1; i < gains.size(); ++i) {
      const double found = match.cameras[i].matrix(channel, channel) / match.cameras[0].matrix(channel, channel);
      EXPECT_NEAR(found * gains[i][channel] / gains[0][channel], 1.0, 0.01) << colours.cameras[i] << channel;
    }
  for (const auto& camera : match.cameras) EXPECT_TRUE(camera.gains_only) << "white tells nothing of other colours";
}

TEST(BoardColours, GreyPicturesAndNoBoardAreRefusedByName) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder.path() / "cam00");
  const auto picture = folder.path() / "cam00" / "a.png";
  write_png(picture, cv::Mat(120, 160, CV_8UC3, cv::Scalar(90, 120, 80)));
  EXPECT_THROW(colours_of_boards(folder.path(), {kBoard}), InvalidInput);
  write_png(picture, cv::Mat(120, 160, CV_8UC1, cv::Scalar(90)));
  try {
    colours_of_boards(folder.path(), {kBoard});
    FAIL() << "grey has no colour";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.png is grey"));
  }
}

}  // namespace
}  // namespace rotunda::capture
