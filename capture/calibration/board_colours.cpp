#include "capture/calibration/board_colours.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <opencv2/imgcodecs.hpp>

#include "capture/calibration/board_folder.h"
#include "capture/picture.h"
#include "capture/srgb.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kLatticeOfSquare = 12;           // places a square's side
constexpr double kFromInk = 2.5;               // blurs, beside the pixel: of a Gaussian 0.6 % is farther out
constexpr int kDarkest = 8, kBrightest = 250;  // levels: beyond, noise or the end of the scale

// Metres on the board of one pixel at a place, along the board's x and y.
Eigen::Vector2d metres_a_pixel(const Eigen::Matrix3d& board_from_image, const Eigen::Vector2d& pixel) {
  const auto at = [&](double dx, double dy) {
    return Eigen::Vector2d(
        (board_from_image * (pixel + Eigen::Vector2d(dx, dy)).eval().homogeneous()).eval().hnormalized());
  };
  const Eigen::Vector2d middle = at(0, 0);
  return (at(1, 0) - middle).cwiseAbs() + (at(0, 1) - middle).cwiseAbs();
}

bool is_white_about(const BoardPrint& print, const Eigen::Vector2d& at, const Eigen::Vector2d& reach) {
  const auto& board = print.board();
  const Eigen::Vector2d half(0.5 * board.columns * board.square, 0.5 * board.rows * board.square);
  if (((at.cwiseAbs() + reach).array() > half.array()).any()) return false;  // the margin's width is not known
  return print.mean(at.x(), at.y(), reach.x(), reach.y()) > 1.0 - 1e-9;
}

// In linear light; nothing where a value is clipped or dark.
std::optional<Eigen::Vector3d> colour_at(const cv::Mat& rgb, const Eigen::Vector2d& pixel) {
  const cv::Point at(cvRound(pixel.x()), cvRound(pixel.y()));
  if (!cv::Rect({}, rgb.size()).contains(at)) return std::nullopt;
  const auto& value = rgb.at<cv::Vec3b>(at);
  for (int c = 0; c < 3; ++c)
    if (value[c] < kDarkest || value[c] > kBrightest) return std::nullopt;
  return linear_of(value);
}

// In colour; empty for a moment without a picture.
cv::Mat read_colour(const fs::path& file) {
  if (file.empty()) return {};
  if (cv::imread(file.string(), cv::IMREAD_UNCHANGED).channels() < 3)
    throw InvalidInput(file.string() + " is grey: the colours of cameras are compared in pictures in colour");
  return read_rgb(file);
}

}  // namespace

std::size_t places_of(const Board& board) {
  return static_cast<std::size_t>(board.columns * board.rows * kLatticeOfSquare * kLatticeOfSquare);
}

std::vector<ColourSample> white_samples(const cv::Mat& rgb, const BoardPrint& print, const FoundBoard& found,
                                        std::size_t camera, std::size_t first_place) {
  const auto& board = print.board();
  const auto corners = corner_positions(board);
  std::vector<PlacedPoint> points;
  for (const auto& corner : found.corners)
    points.push_back({corners[static_cast<std::size_t>(corner.corner)].head<2>(), corner.pixel});
  std::vector<ColourSample> samples;
  const auto H = local_homography(points, Eigen::Vector2d::Zero(), points.size());
  if (!H) return samples;
  const Eigen::Matrix3d board_from_image = H->inverse();
  const double step = board.square / kLatticeOfSquare;
  const double from_ink = 1.0 + kFromInk * found.blur_px;  // half a pixel to its edge, half to where it is read
  const int columns = board.columns * kLatticeOfSquare, rows = board.rows * kLatticeOfSquare;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d at((column + 0.5 - 0.5 * columns) * step, (0.5 * rows - row - 0.5) * step);
      const Eigen::Vector2d pixel = (*H * at.homogeneous()).hnormalized();
      if (!is_white_about(print, at, from_ink * metres_a_pixel(board_from_image, pixel))) continue;
      if (const auto colour = colour_at(rgb, pixel))
        samples.push_back({camera, first_place + static_cast<std::size_t>(row * columns + column), *colour});
    }
  return samples;
}

BoardColours colours_of_boards(const fs::path& folder, const std::vector<Board>& boards,
                               const std::function<void(std::size_t, std::size_t)>& progress) {
  const auto read = read_board_folder(folder);
  const auto& pictures = read.pictures;
  const BoardDetector detector(boards);
  std::size_t places = 0;
  std::vector<std::size_t> first_place;  // of each board, within a moment
  for (const auto& board : boards) first_place.push_back(places), places += places_of(board);
  const std::size_t cameras = pictures.cameras.size(), moments = pictures.moments.size();
  std::vector<std::vector<ColourSample>> found(cameras * moments);
  std::atomic<std::size_t> done = 0, with_board = 0;
  std::mutex telling;
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
    const std::size_t camera = i / moments, moment = i % moments;
    const cv::Mat rgb = read_colour(pictures.file(camera, moment));
    cv::Mat green;
    if (!rgb.empty()) cv::extractChannel(rgb, green, 1);
    for (const auto& board : green.empty() ? std::vector<FoundBoard>{} : detector.detect(green)) {
      const auto samples =
          white_samples(rgb, detector.print(board.board), board, camera, moment * places + first_place[board.board]);
      found[i].insert(found[i].end(), samples.begin(), samples.end());
      ++with_board;
    }
    const std::scoped_lock lock(telling);
    if (progress) progress(++done, found.size());
  });
  BoardColours colours{.cameras = pictures.cameras, .samples = {}, .pictures = with_board};
  for (const auto& some : found) colours.samples.insert(colours.samples.end(), some.begin(), some.end());
  if (with_board == 0) throw InvalidInput("no board was found in any picture of " + folder.string());
  return colours;
}

}  // namespace rotunda::capture
