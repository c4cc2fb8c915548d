#include "capture/calibration/board_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <opencv2/aruco.hpp>
#include <opencv2/imgcodecs.hpp>

#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

template <class Work>
std::string refusal(Work work) {
  try {
    work();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

// An independent finder of markers measures the picture: each corner within a third of a pixel of where it must be.
TEST(BoardSheet, IsPrintedInTrueSize) {
  const test::TemporaryFolder folder;
  Board board{.columns = 5, .rows = 4, .square = 0.031, .marker = 0.023, .first_marker = 7};
  const auto paper = paper_named("A4", board);
  const double dpi = 200.0, pixels = dpi / 0.0254;
  write_board_sheets(folder.path() / "board.png", std::span(&board, 1), std::span(&paper, 1), dpi);
  const cv::Mat picture = cv::imread((folder.path() / "board.png").string(), cv::IMREAD_GRAYSCALE);
  ASSERT_NEAR(picture.cols, 0.297 * pixels, 1.0);
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> found;
  const auto finder = cv::aruco::DetectorParameters::create();
  finder->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  cv::aruco::detectMarkers(picture, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50), found, ids, finder);
  ASSERT_EQ(ids.size(), 10U);
  for (const auto& marker : markers_of(board)) {
    const auto at = std::find(ids.begin(), ids.end(), marker.id);
    ASSERT_NE(at, ids.end()) << marker.id;
    const auto corners = marker_corners(board, marker);
    for (std::size_t i = 0; i < 4; ++i) {
      // cairo counts pixels from their corner, OpenCV from their centre.
      const double x = (0.297 / 2 + corners[i].x()) * pixels - 0.5, y = (0.210 / 2 - corners[i].y()) * pixels - 0.5;
      const auto& corner = found[static_cast<std::size_t>(at - ids.begin())][i];
      EXPECT_NEAR(corner.x, x, 0.34);
      EXPECT_NEAR(corner.y, y, 0.34);
    }
  }
  // 7874 pixels a metre, said in the file.
  EXPECT_THAT(bytes_of(folder.path() / "board.png"), HasSubstr(std::string("pHYs\0\0\x1E\xC2\0\0\x1E\xC2\x01", 13)));
}

TEST(BoardSheet, ManyBoardsAreAPageEachWithMarkersOfTheirOwn) {
  const test::TemporaryFolder folder;
  const auto boards = told_apart(Board{}, 3);
  EXPECT_EQ(boards[2].first_marker, 24);
  std::vector<PaperSize> papers;
  for (const auto& board : boards) papers.push_back(smallest_paper(board));
  EXPECT_EQ(papers[0].name, "A0");
  EXPECT_THAT(write_board_sheets(folder.path() / "b.pdf", boards, papers), ElementsAre(folder.path() / "b.pdf"));
  const auto pdf = bytes_of(folder.path() / "b.pdf");
  EXPECT_THAT(pdf, HasSubstr("/Count 3"));
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [ 0 0 3370.3"));  // 1189 mm in points
  const auto files = write_board_sheets(folder.path() / "b.svg", boards, papers);
  EXPECT_EQ(files[1].filename(), "b-board1.svg");
  EXPECT_THAT(bytes_of(files[1]), HasSubstr("width=\"3370.3"));
}

TEST(BoardSheet, ItsYamlReadsBackAsTheSameBoards) {
  const test::TemporaryFolder folder;
  std::vector<Board> boards = told_apart(Board{.square = 0.1234567, .marker = 0.09}, 2);
  boards[1].name = "the \"second\": one";
  boards.push_back(
      {.name = "plain", .type = BoardType::chessboard, .columns = 10, .rows = 7, .square = 0.1, .marker = 0});
  std::ofstream(folder.path() / "board.yaml") << board_yaml(boards);
  const auto read = read_boards(folder.path() / "board.yaml");
  ASSERT_EQ(read.size(), 3U);
  EXPECT_EQ(read[1].name, boards[1].name);
  EXPECT_NEAR(read[0].square, boards[0].square, 1e-12);
  EXPECT_EQ(read[1].first_marker, 12);
  EXPECT_EQ(read[2].columns, 10);
}

TEST(BoardSheet, FillsThePaperInWholeMillimetres) {
  const Board fitted = fitted_to(Board{.columns = 6, .rows = 4}, "A3");
  EXPECT_DOUBLE_EQ(fitted.square, 0.066);  // 6 x 66 + 20 = 416 of 420 mm
  EXPECT_DOUBLE_EQ(fitted.marker, 0.8 * 0.066);
  EXPECT_EQ(paper_named("A3", Board{.columns = 4, .rows = 6, .square = 0.06, .marker = 0.04}).width, 0.297);
}

TEST(BoardSheet, WhatDoesNotFitIsRefusedWithItsSizes) {
  const Board large{.square = 0.25, .marker = 0.2};
  EXPECT_THAT(refusal([&] { smallest_paper(large); }), HasSubstr("1500 x 1000 mm"));
  const auto paper = paper_named("A4", large);
  EXPECT_THAT(refusal([&] { write_board_sheets("never.pdf", std::span(&large, 1), std::span(&paper, 1)); }),
              HasSubstr("1520 x 1020"));
  EXPECT_THAT(refusal([&] { paper_named("A9", large); }), HasSubstr("A9"));
  EXPECT_THAT(refusal([] { told_apart(Board{}, 5); }), HasSubstr("DICT_4X4_50"));
  EXPECT_THAT(refusal([] { told_apart({.type = BoardType::chessboard, .marker = 0}, 2); }), HasSubstr("told apart"));
  EXPECT_FALSE(fs::exists("never.pdf"));
}

}  // namespace
}  // namespace rotunda::capture
