#include "capture/calibration/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "simulator/people/board_prop.h"

namespace rotunda::capture {
namespace {

using testing::HasSubstr;

std::filesystem::path file_with(const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) /
                    (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".yaml");
  std::ofstream(file) << text;
  return file;
}

// The black rectangles as a picture of `pixels` a square.
cv::Mat drawn(const Board& board, int pixels) {
  cv::Mat picture(board.rows * pixels, board.columns * pixels, CV_8UC1, cv::Scalar(255));
  const auto to_pixel = [&](double metres) { return static_cast<int>(std::lround(metres / board.square * pixels)); };
  for (const auto& box : black_rectangles(board)) {
    const cv::Point a(to_pixel(box.min().x() + 0.5 * board.columns * board.square),
                      to_pixel(0.5 * board.rows * board.square - box.max().y()));
    const cv::Point b(to_pixel(box.max().x() + 0.5 * board.columns * board.square),
                      to_pixel(0.5 * board.rows * board.square - box.min().y()));
    picture(cv::Rect(a, b)).setTo(0);
  }
  return picture;
}

TEST(Board, PrintsWhatOpenCvPrints) {
  for (const int rows : {4, 5}) {
    const Board board{.columns = 6, .rows = rows, .square = 0.180, .marker = 0.120};
    const auto reference = cv::aruco::CharucoBoard::create(6, rows, 0.180F, 0.120F,
                                                           cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50));
    cv::Mat expected;
    reference->draw({6 * 90, rows * 90}, expected, 0, 1);
    // OpenCV's drawing may be a pixel off where edges lie between pixels.
    cv::Mat different = drawn(board, 90) != expected;
    cv::erode(different, different, cv::Mat::ones(3, 3, CV_8U));
    EXPECT_EQ(cv::countNonZero(different), 0) << rows;
  }
}

TEST(Board, HasTheCornersOfTheCarriedBoard) {
  const auto file = file_with(simulator::board_yaml());
  const auto boards = read_boards(file);
  ASSERT_EQ(boards.size(), 1U);
  EXPECT_EQ(boards[0].type, BoardType::charuco);
  const auto corners = corner_positions(boards[0]), truth = simulator::board_corners();
  ASSERT_EQ(static_cast<int>(corners.size()), corner_count(boards[0]));
  ASSERT_EQ(corners.size(), truth.size());
  for (std::size_t i = 0; i < corners.size(); ++i) EXPECT_LT((corners[i] - truth[i]).norm(), 1e-12);
}

TEST(Board, ReadsAChessboardBetweenOthers) {
  const auto boards = read_boards(
      file_with("boards:\n"
                "- {name: floor, type: chessboard, inner_corners: [9, 6], square_mm: 100}\n"
                "- {type: charuco, squares: [6, 4], square_mm: 180, marker_mm: 144, dictionary: DICT_4X4_50}\n"
                "- {type: charuco, squares: [5, 7], square_mm: 40, marker_mm: 30, dictionary: DICT_4X4_50, "
                "first_marker: 12}\n"));
  ASSERT_EQ(boards.size(), 3U);
  EXPECT_EQ(boards[0].name, "floor");
  EXPECT_EQ(corner_count(boards[0]), 54);
  EXPECT_FALSE(looks_the_same_upside_down(boards[0]));
  EXPECT_TRUE(markers_of(boards[0]).empty());
  EXPECT_EQ(boards[1].name, "board1");
  EXPECT_EQ(markers_of(boards[2]).front().id, 12);
  EXPECT_EQ(markers_of(boards[2]).size(), 17U);
}

TEST(Board, TellsEveryMistakeOfAFile) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      read_boards(file_with(text));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string good = "type: charuco\nsquares: [6, 4]\nsquare_mm: 180\nmarker_mm: 144\ndictionary: DICT_4X4_50\n";
  EXPECT_EQ(message(good), "accepted");
  EXPECT_THAT(message("type: charuco\nsquares: [6]\nsquare_mm: no\n"),
              testing::AllOf(HasSubstr("squares"), HasSubstr("square_mm"), HasSubstr("marker_mm")));
  EXPECT_THAT(message("type: charuco\nsquares: [6, 4]\nsquare_mm: 180\nmarker_mm: 144\ndictionary: DICT_4X4_5\n"),
              HasSubstr("is DICT_4X4_50 meant"));
  EXPECT_THAT(message(good + "first_marker: 40\n"), HasSubstr("wants 40 to 51"));
  EXPECT_THAT(message("type: charuco\nsquares: [6, 4]\nsquare_mm: 100\nmarker_mm: 144\ndictionary: DICT_4X4_50\n"),
              HasSubstr("less than 100"));
  EXPECT_THAT(message("boards: [{type: chessboard, inner_corners: [9, 6], square_mm: 1}, {type: chessboard, "
                      "inner_corners: [6, 9], square_mm: 2}]"),
              HasSubstr("cannot be told from board0"));
  EXPECT_THAT(message("type: dots\n"), HasSubstr("charuco or chessboard"));
  EXPECT_THAT(message("type: [\n"), HasSubstr("no YAML"));
  EXPECT_THAT(message(""), HasSubstr("expected"));
  EXPECT_THROW(read_boards("no/such/board.yaml"), ConfigError);
}

}  // namespace
}  // namespace rotunda::capture
