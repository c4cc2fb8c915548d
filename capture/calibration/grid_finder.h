#pragma once
// Where boards are in a picture, to a pixel or so: the corners of a ChArUco board's markers, the grid of a chessboard.
// OpenCV finds both; here they are put in the board's order and freed of what does not belong to it.
#include "capture/calibration/board_detector.h"

namespace rotunda::capture {

struct FoundGrid {
  std::size_t board = 0;
  std::vector<PlacedPoint> points;  // four or more
};

// `grey` CV_8UC1.
std::vector<FoundGrid> find_grids(const cv::Mat& grey, std::span<const Board> boards);

// How many markers of the dictionary are seen at all, whatever board they are on: tells a wrong board file.
int count_markers(const cv::Mat& grey, const std::string& dictionary);

}  // namespace rotunda::capture
