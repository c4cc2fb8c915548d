#pragma once
// Finds boards in a grey picture: markers or a chessboard's grid first (OpenCV), then every inner corner by fitting the
// print itself (corner_fit.h), which stays right under blur, slant and strong distortion. OpenCV 4.6's interpolated
// ChArUco corners lie 0.44 px off, and are not used.
#include <optional>
#include <span>
#include <vector>

#include "capture/calibration/board_print.h"
#include "capture/calibration/corner_fit.h"

namespace rotunda::capture {

struct FoundCorner {
  int corner = 0;  // of the board
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double deviation = 0.0;  // as the fit judges itself, pixels a axis
};

struct FoundBoard {
  std::size_t board = 0;  // number in the detector's boards
  std::vector<FoundCorner> corners;
  double blur_px = 0.0;  // of the picture about it
};

class BoardDetector {
 public:
  // Throws InvalidInput for boards that cannot be printed or told apart.
  explicit BoardDetector(std::vector<Board> boards);

  const std::vector<Board>& boards() const { return boards_; }
  const BoardPrint& print(std::size_t board) const { return prints_[board]; }

  // Every board with at least four corners that span an area. CV_8UC1 or CV_16UC1 on the sRGB curve; throws
  // InvalidInput for other types.
  std::vector<FoundBoard> detect(const cv::Mat& grey) const;

 private:
  std::vector<Board> boards_;
  std::vector<BoardPrint> prints_;
};

// A board's point and where it is in a picture.
struct PlacedPoint {
  Eigen::Vector2d on_board, pixel;
};
// The homography (metres to pixels) that fits the points nearest to `at` best; nothing if they do not span an area.
std::optional<Eigen::Matrix3d> local_homography(std::span<const PlacedPoint> points, const Eigen::Vector2d& at,
                                                std::size_t nearest);

// Whether corners lie spread over an area (not along a line), as poses and homographies need.
bool span_an_area(std::span<const FoundCorner> corners, const Board& board);

}  // namespace rotunda::capture
