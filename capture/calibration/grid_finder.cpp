#include "capture/calibration/grid_finder.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/calibration/square_lattice.h"

namespace rotunda::capture {
namespace {

constexpr int kEnlargedBelow = 2000;  // pixels of width: small pictures are searched again at twice the size
constexpr double kLensBend = 0.03;    // of the picture's width: how far lenses bend a board out of a homography

struct Markers {
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> corners;
};

Markers detect(const cv::Mat& grey, const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  parameters->cornerRefinementWinSize = 3;
  Markers found;
  cv::aruco::detectMarkers(grey, dictionary, found.corners, found.ids, parameters);
  return found;
}

// At twice the size: pixel (x, y) lies at (2 x + 1/2, 2 y + 1/2) there.
Markers detect_enlarged(const cv::Mat& grey, const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  cv::Mat large;
  cv::resize(grey, large, {}, 2.0, 2.0, cv::INTER_CUBIC);
  auto found = detect(large, dictionary);
  for (auto& marker : found.corners)
    for (auto& corner : marker) corner = {(corner.x - 0.5F) / 2.0F, (corner.y - 0.5F) / 2.0F};
  return found;
}

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const std::string& name) {
  return cv::aruco::getPredefinedDictionary(dictionary_number(name));
}

std::vector<PlacedPoint> on_board(const Markers& markers, const Board& board) {
  std::map<int, BoardMarker> known;
  for (const auto& marker : markers_of(board)) known[marker.id] = marker;
  std::vector<PlacedPoint> points;
  for (std::size_t i = 0; i < markers.ids.size(); ++i) {
    const auto marker = known.find(markers.ids[i]);
    if (marker == known.end() || std::count(markers.ids.begin(), markers.ids.end(), markers.ids[i]) > 1) continue;
    const auto places = marker_corners(board, marker->second);
    for (std::size_t corner = 0; corner < 4; ++corner)
      points.push_back({places[corner].head<2>(), {markers.corners[i][corner].x, markers.corners[i][corner].y}});
  }
  return points;
}

// Without markers that are read wrongly: those that do not lie on the board's plane as most do.
std::vector<PlacedPoint> agreeing(const std::vector<PlacedPoint>& points, int width) {
  if (points.size() < 8) return points;
  std::vector<cv::Point2d> from, to;
  for (const auto& p : points) {
    from.emplace_back(p.on_board.x(), p.on_board.y());
    to.emplace_back(p.pixel.x(), p.pixel.y());
  }
  std::vector<std::uint8_t> inlier;
  const cv::Mat H = cv::findHomography(from, to, cv::RANSAC, std::max(3.0, kLensBend * width), inlier);
  if (H.empty()) return {};
  std::vector<PlacedPoint> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (inlier[i] != 0) kept.push_back(points[i]);
  return kept;
}

void append_charuco(const cv::Mat& grey, std::span<const Board> boards, std::vector<FoundGrid>& grids) {
  std::map<std::string, std::vector<std::size_t>> by_dictionary;
  for (std::size_t i = 0; i < boards.size(); ++i)
    if (boards[i].type == BoardType::charuco) by_dictionary[boards[i].dictionary].push_back(i);
  for (const auto& [name, members] : by_dictionary) {
    const auto dictionary = dictionary_of(name);
    auto markers = detect(grey, dictionary);
    const std::size_t wanted = markers_of(boards[members.front()]).size();
    if (2 * markers.ids.size() < wanted && grey.cols < kEnlargedBelow) {
      auto more = detect_enlarged(grey, dictionary);
      if (more.ids.size() > markers.ids.size()) markers = std::move(more);
    }
    for (const std::size_t i : members) {
      auto points = agreeing(on_board(markers, boards[i]), grey.cols);
      if (points.size() >= 4) grids.push_back({i, std::move(points)});
    }
  }
}

using Grid = std::vector<cv::Point2f>;  // row by row

// Pixel (x, y) of a picture of half the size lies at (2 x + 1/2, 2 y + 1/2).
Grid at_full_size(Grid corners) {
  for (auto& corner : corners) corner = {2.0F * corner.x + 0.5F, 2.0F * corner.y + 0.5F};
  return corners;
}

// Most boards are large enough at half the size, where telling that there is none takes a tenth of the time. At full
// size boards are sought only where squares enough are to be seen. What these find too small is told by its squares.
std::optional<Grid> find_chessboard(const cv::Mat& grey, const cv::Size& inner) {
  Grid corners;
  constexpr int kFlags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  cv::Mat half;
  cv::resize(grey, half, {}, 0.5, 0.5, cv::INTER_AREA);
  if (cv::findChessboardCorners(half, inner, corners, kFlags)) return at_full_size(std::move(corners));
  if (cv::findChessboardCornersSB(half, inner, corners, cv::CALIB_CB_NORMALIZE_IMAGE))
    return at_full_size(std::move(corners));
  if (cv::checkChessboard(half, inner) || cv::checkChessboard(grey, inner)) {
    if (cv::findChessboardCorners(grey, inner, corners, kFlags)) return corners;
    if (cv::findChessboardCornersSB(grey, inner, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) return corners;
  }
  return find_square_lattice(grey, inner);
}

// The ways in which a grid may have been listed: as found, from the other end, each with its rows the other way about.
std::vector<Grid> listings(const Grid& grid, const cv::Size& inner) {
  Grid turned(grid.rbegin(), grid.rend()), mirrored;
  for (int row = inner.height - 1; row >= 0; --row)
    for (int column = 0; column < inner.width; ++column)
      mirrored.push_back(grid[static_cast<std::size_t>(row * inner.width + column)]);
  std::vector<Grid> all{grid, turned, mirrored, Grid(mirrored.rbegin(), mirrored.rend())};
  if (inner.width == inner.height)  // lying as well as standing
    for (std::size_t i = 0; i < 4; ++i) {
      Grid lying;
      for (int column = 0; column < inner.width; ++column)
        for (int row = 0; row < inner.height; ++row)
          lying.push_back(all[i][static_cast<std::size_t>(row * inner.width + column)]);
      all.push_back(std::move(lying));
    }
  return all;
}

std::vector<PlacedPoint> placed(const Board& board, const Grid& grid) {
  const auto positions = corner_positions(board);
  std::vector<PlacedPoint> points;
  for (std::size_t i = 0; i < positions.size(); ++i) points.push_back({positions[i].head<2>(), {grid[i].x, grid[i].y}});
  return points;
}

// White minus black of the board's squares if it is listed so; negative: the other way about. Nothing if its right and
// its down turn the wrong way, as seen through the board.
std::optional<double> contrast(const cv::Mat& grey, const Board& board, std::span<const PlacedPoint> points) {
  const auto H = local_homography(points, Eigen::Vector2d::Zero(), points.size());
  if (!H || H->determinant() > 0.0) return std::nullopt;  // y is up on the board and down in the picture
  double sum = 0.0;
  for (int row = 1; row + 1 < board.rows; ++row)
    for (int column = 1; column + 1 < board.columns; ++column) {
      const Eigen::Vector2d middle((column + 0.5 - 0.5 * board.columns) * board.square,
                                   (0.5 * board.rows - row - 0.5) * board.square);
      const Eigen::Vector2d pixel = (*H * middle.homogeneous()).hnormalized();
      const cv::Point at(cvRound(pixel.x()), cvRound(pixel.y()));
      if (cv::Rect({}, grey.size()).contains(at))
        sum += (is_black(column, row) ? -1.0 : 1.0) * grey.at<std::uint8_t>(at);
    }
  return sum;
}

// The listing that agrees with the print. Where two do (looks_the_same_upside_down) the one with its right to the
// right.
std::vector<PlacedPoint> in_board_order(const cv::Mat& grey, const Board& board, const Grid& grid) {
  std::vector<PlacedPoint> best;
  double highest = 0.0;
  for (const auto& listing : listings(grid, {board.columns - 1, board.rows - 1})) {
    auto points = placed(board, listing);
    const auto found = contrast(grey, board, points);
    if (!found) continue;
    const double to_the_right = points.back().pixel.x() - points.front().pixel.x();
    const double score = *found * (to_the_right > 0 ? 1.0 : 0.9);
    if (score <= highest) continue;
    highest = score;
    best = std::move(points);
  }
  return best;
}

}  // namespace

std::vector<FoundGrid> find_grids(const cv::Mat& grey, std::span<const Board> boards) {
  std::vector<FoundGrid> grids;
  append_charuco(grey, boards, grids);
  for (std::size_t i = 0; i < boards.size(); ++i) {
    if (boards[i].type != BoardType::chessboard) continue;
    const auto grid = find_chessboard(grey, {boards[i].columns - 1, boards[i].rows - 1});
    if (!grid) continue;
    auto points = in_board_order(grey, boards[i], *grid);
    if (!points.empty()) grids.push_back({i, std::move(points)});
  }
  return grids;
}

int count_markers(const cv::Mat& grey, const std::string& dictionary) {
  return static_cast<int>(detect(grey, dictionary_of(dictionary)).ids.size());
}

}  // namespace rotunda::capture
