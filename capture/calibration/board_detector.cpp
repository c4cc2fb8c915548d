#include "capture/calibration/board_detector.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture/calibration/grid_finder.h"

namespace rotunda::capture {
namespace {

constexpr std::array kBlurs = {0.5, 0.7, 1.0, 1.4, 2.0, 2.8};  // pixels
constexpr double kMiddleBlur = 1.0;                            // where corners are looked for before the blur is known
constexpr std::size_t kNearest = 12;                           // points a local homography rests on
constexpr std::size_t kBlurCorners = 6;                        // corners that tell a picture's blur
constexpr double kFirstReach = 3.5, kSecondReach = 1.5;        // pixels
constexpr std::size_t kFewest = 4;

struct Expected {
  int corner;
  Eigen::Vector2d on_board;
  Eigen::Matrix3d image_from_board;
};

std::vector<Expected> expected_corners(const Board& board, std::span<const PlacedPoint> points, double within) {
  std::vector<Expected> all;
  const auto corners = corner_positions(board);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d at = corners[i].head<2>();
    const auto near = std::count_if(points.begin(), points.end(),
                                    [&](const auto& p) { return (p.on_board - at).norm() <= within * board.square; });
    if (near == 0) continue;
    if (const auto H = local_homography(points, at, kNearest)) all.push_back({static_cast<int>(i), at, *H});
  }
  return all;
}

// The blur with which the print looks most like the picture, by a few corners of the middle.
double blur_of(const cv::Mat& linear, const BoardPrint& print, std::vector<Expected> corners) {
  std::sort(corners.begin(), corners.end(),
            [](const auto& a, const auto& b) { return a.on_board.norm() < b.on_board.norm(); });
  corners.resize(std::min(corners.size(), kBlurCorners));
  std::array<double, kBlurs.size()> sums{};
  for (const auto& corner : corners) {
    const auto correlations =
        correlation_at_blurs(linear, print, corner.on_board, corner.image_from_board,
                             {.blur_px = kMiddleBlur, .reach_px = kFirstReach, .least_correlation = 0.5}, kBlurs);
    for (std::size_t i = 0; i < correlations.size(); ++i) sums[i] += correlations[i];
  }
  const auto best = std::max_element(sums.begin(), sums.end());
  return *best > 0.0 ? kBlurs[static_cast<std::size_t>(best - sums.begin())] : kMiddleBlur;
}

std::vector<FoundCorner> fit_all(const cv::Mat& linear, const BoardPrint& print, std::span<const Expected> corners,
                                 double blur, double reach) {
  std::vector<FoundCorner> found;
  for (const auto& corner : corners)
    if (const auto fit =
            fit_corner(linear, print, corner.on_board, corner.image_from_board, {.blur_px = blur, .reach_px = reach}))
      found.push_back({corner.corner, fit->pixel, fit->deviation});
  return found;
}

std::vector<PlacedPoint> placed(const Board& board, std::span<const FoundCorner> corners) {
  const auto positions = corner_positions(board);
  std::vector<PlacedPoint> points;
  for (const auto& corner : corners)
    points.push_back({positions[static_cast<std::size_t>(corner.corner)].head<2>(), corner.pixel});
  return points;
}

// Twice: where the markers say the corners are is a pixel off at most; where the neighbours say, much less.
std::optional<FoundBoard> refined(const cv::Mat& linear, const BoardPrint& print, std::span<const PlacedPoint> points) {
  const Board& board = print.board();
  const auto first = expected_corners(board, points, 1.3);
  FoundBoard found;
  found.blur_px = blur_of(linear, print, first);
  found.corners = fit_all(linear, print, first, found.blur_px, kFirstReach);
  if (!span_an_area(found.corners, board)) return std::nullopt;
  const auto second = expected_corners(board, placed(board, found.corners), 1.5);
  const auto again = fit_all(linear, print, second, found.blur_px, kSecondReach);
  if (span_an_area(again, board)) found.corners = again;
  return found;
}

Eigen::Matrix3d to_unit(std::span<const PlacedPoint> points, bool pixels) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += (pixels ? p.pixel : p.on_board) / static_cast<double>(points.size());
  double spread = 0.0;
  for (const auto& p : points)
    spread += ((pixels ? p.pixel : p.on_board) - mean).norm() / static_cast<double>(points.size());
  const double scale = spread > 0.0 ? std::sqrt(2.0) / spread : 1.0;
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topLeftCorner<2, 2>() *= scale;
  T.topRightCorner<2, 1>() = -scale * mean;
  return T;
}

double smallest_spread(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const auto& p : points) scatter += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues()[0]);
}

}  // namespace

// Hartley's normalised direct linear transform (Hartley, Zisserman 2004, algorithm 4.2).
std::optional<Eigen::Matrix3d> local_homography(std::span<const PlacedPoint> all, const Eigen::Vector2d& at,
                                                std::size_t nearest) {
  std::vector<PlacedPoint> points(all.begin(), all.end());
  std::stable_sort(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return (a.on_board - at).squaredNorm() < (b.on_board - at).squaredNorm();
  });
  points.resize(std::min(points.size(), nearest));
  if (points.size() < kFewest) return std::nullopt;
  const Eigen::Matrix3d board_unit = to_unit(points, false), pixel_unit = to_unit(points, true);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  std::vector<Eigen::Vector2d> unit_points;
  for (const auto& point : points) {
    const Eigen::Vector2d b = (board_unit * point.on_board.homogeneous()).head<2>(),
                          p = (pixel_unit * point.pixel.homogeneous()).head<2>();
    unit_points.push_back(b);
    Eigen::Matrix<double, 2, 9> row;
    row << b.x(), b.y(), 1, 0, 0, 0, -p.x() * b.x(), -p.x() * b.y(), -p.x(),  //
        0, 0, 0, b.x(), b.y(), 1, -p.y() * b.x(), -p.y() * b.y(), -p.y();
    normal += row.transpose() * row;
  }
  if (smallest_spread(unit_points) < 0.1) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  if (solver.eigenvalues()[1] < 1e-9) return std::nullopt;  // three of four on a line
  Eigen::Matrix3d H =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(solver.eigenvectors().col(0).data());
  H = pixel_unit.inverse() * H * board_unit;
  if ((H * at.homogeneous()).z() < 0.0) H = -H;
  return H;
}

bool span_an_area(std::span<const FoundCorner> corners, const Board& board) {
  if (corners.size() < kFewest) return false;
  const auto positions = corner_positions(board);
  std::vector<Eigen::Vector2d> points;
  for (const auto& corner : corners) points.push_back(positions[static_cast<std::size_t>(corner.corner)].head<2>());
  return smallest_spread(points) > 0.3 * board.square;
}

BoardDetector::BoardDetector(std::vector<Board> boards) : boards_(std::move(boards)) {
  check_boards(boards_);
  for (const auto& board : boards_) prints_.emplace_back(board);
}

std::vector<FoundBoard> BoardDetector::detect(const cv::Mat& grey) const {
  const cv::Mat linear = linear_light(grey);
  cv::Mat eight_bit = grey;
  if (grey.type() == CV_16UC1) grey.convertTo(eight_bit, CV_8U, 1.0 / 257.0);
  std::vector<FoundBoard> found;
  for (const auto& grid : find_grids(eight_bit, boards_)) {
    auto board = refined(linear, prints_[grid.board], grid.points);
    if (!board) continue;
    board->board = grid.board;
    found.push_back(std::move(*board));
  }
  return found;
}

}  // namespace rotunda::capture
