#include "capture/calibration/square_lattice.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/calibration/lattice_growth.h"

namespace rotunda::capture {
namespace {

constexpr std::array kBlurs = {2.0, 3.5};  // pixels
constexpr double kLargestSquare = 6.0;     // blurs: a larger one has its blobs in its corners
constexpr double kLevelBlur = 0.7;         // pixels
constexpr double kLeastFound = 0.9;        // of a board's black squares
constexpr double kOuterLine = 0.6;         // of a line's black squares
constexpr double kAsABoard = 0.95;         // of its squares are darker or lighter than their neighbours, as they must
constexpr double kGoesOn = 0.5;            // of the first square's contrast: black and white beyond the rim
constexpr int kMiddleRounds = 8;
constexpr double kMiddleReach = 0.6;  // squares

struct Bounds {
  Place low{}, high{};
  int side(std::size_t axis) const { return high[axis] - low[axis] + 1; }
};

Bounds bounds_of(const Lattice& lattice) {
  Bounds bounds{lattice.begin()->first, lattice.begin()->first};
  for (const auto& [place, blob] : lattice)
    for (const std::size_t axis : {0U, 1U}) {
      bounds.low[axis] = std::min(bounds.low[axis], place[axis]);
      bounds.high[axis] = std::max(bounds.high[axis], place[axis]);
    }
  return bounds;
}

// What lies dark beyond the board's white margin may pass for squares of it: a line at the rim of which most is missing
// is none of the board.
void trim(Lattice& lattice) {
  const auto trim_one = [&] {
    const Bounds bounds = bounds_of(lattice);
    for (const std::size_t axis : {0U, 1U})
      for (const int line : {bounds.low[axis], bounds.high[axis]}) {
        const auto on_line = [&](const auto& entry) { return entry.first[axis] == line; };
        const auto found = static_cast<double>(std::count_if(lattice.begin(), lattice.end(), on_line));
        if (found < kOuterLine * 0.5 * bounds.side(1 - axis)) return std::erase_if(lattice, on_line) > 0;
      }
    return false;
  };
  while (!lattice.empty() && trim_one()) {
  }
}

// The picture's levels on a lattice's squares.
class SquareLevels {
 public:
  // `blobs`: each somewhere on its square.
  SquareLevels(const cv::Mat& levels, std::vector<PlacedPoint> blobs) : levels_(levels), squares_(std::move(blobs)) {
    auto middles = squares_;
    for (auto& square : middles) square.pixel = middle_of(square);
    squares_ = std::move(middles);
  }

  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& place) const {
    const auto H = local_homography(squares_, place, kForetoldBy);
    return H ? std::optional<Eigen::Vector2d>(carried(*H, place)) : std::nullopt;
  }
  // White minus black of two squares side by side; nothing outside the picture.
  std::optional<double> contrast(const Place& square, const Place& neighbour) const {
    const auto a = level(square), b = level(neighbour);
    if (!a || !b) return std::nullopt;
    return is_black(square) ? *b - *a : *a - *b;
  }
  static bool is_black(const Place& square) { return (square[0] + square[1]) % 2 == 0; }

 private:
  std::optional<double> level(const Place& square) const {
    const auto at_pixel = pixel(at(square));
    return at_pixel ? value_at(*at_pixel) : std::nullopt;
  }
  // A wide square may have a blob at either end: its middle is the mean of what is dark in a square's reach, mean after
  // mean (Comaniciu, Meer 2002).
  Eigen::Vector2d middle_of(const PlacedPoint& square) const {
    const auto H = local_homography(squares_, square.on_board, kForetoldBy);
    if (!H) return square.pixel;
    Eigen::Vector2d middle = square.pixel;
    Eigen::Matrix2d steps;
    for (int axis = 0; axis < 2; ++axis)
      steps.col(axis) = carried(*H, square.on_board + Eigen::Vector2d::Unit(axis)) - carried(*H, square.on_board);
    const bool is_square = std::abs(steps.determinant()) > 1.0 && steps.cwiseAbs().maxCoeff() < levels_.cols;
    if (!is_square) return square.pixel;  // nor are infinite ones
    double white = 0.0;
    for (const auto& side : kSides) white = std::max(white, value_at(middle + steps * at(side)).value_or(0.0));
    for (int i = 0; i < kMiddleRounds; ++i) middle = mean_of_dark(middle, steps, white);
    return middle;
  }
  Eigen::Vector2d mean_of_dark(const Eigen::Vector2d& about, const Eigen::Matrix2d& steps, double white) const {
    const Eigen::Matrix2d place_from_pixel = steps.inverse();
    const Eigen::Vector2d reach = kMiddleReach * steps.cwiseAbs().rowwise().sum();
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weights = 0.0;
    for (int y = static_cast<int>(about.y() - reach.y()); y <= about.y() + reach.y(); ++y)
      for (int x = static_cast<int>(about.x() - reach.x()); x <= about.x() + reach.x(); ++x) {
        const Eigen::Vector2d pixel(x, y);
        if ((place_from_pixel * (pixel - about)).cwiseAbs().maxCoeff() > kMiddleReach) continue;
        const double weight = std::max(0.0, white - value_at(pixel).value_or(white));
        sum += weight * pixel;
        weights += weight;
      }
    return weights > 0.0 ? Eigen::Vector2d(sum / weights) : about;
  }
  std::optional<double> value_at(const Eigen::Vector2d& pixel) const {
    const cv::Point nearest(cvRound(pixel.x()), cvRound(pixel.y()));
    if (!cv::Rect({}, levels_.size()).contains(nearest)) return std::nullopt;
    return levels_.at<float>(nearest);
  }
  const cv::Mat& levels_;
  std::vector<PlacedPoint> squares_;
};

// Whether black and white take turns throughout.
bool is_a_board(const SquareLevels& squares, const Bounds& bounds, double clear) {
  int right = 0, all = 0;
  for (int row = bounds.low[1]; row <= bounds.high[1]; ++row)
    for (int column = bounds.low[0]; column <= bounds.high[0]; ++column)
      for (const auto& way : {kSides[0], kSides[2]}) {
        const Place next = Place{column, row} + way;
        if (next[0] > bounds.high[0] || next[1] > bounds.high[1]) continue;
        ++all;
        if (squares.contrast({column, row}, next).value_or(0.0) > clear) ++right;
      }
  return right >= kAsABoard * all;
}

// Whether they go on beyond the rim: a larger board, of which a part was found.
bool goes_on(const SquareLevels& squares, const Bounds& bounds, double clear) {
  for (const std::size_t axis : {0U, 1U})
    for (const bool low : {true, false}) {
      double sum = 0.0;
      int count = 0;
      for (int along = bounds.low[1 - axis]; along < bounds.high[1 - axis]; ++along) {
        Place square{}, next{};
        square[axis] = next[axis] = low ? bounds.low[axis] - 1 : bounds.high[axis] + 1;
        square[1 - axis] = along, next[1 - axis] = along + 1;
        if (const auto contrast = squares.contrast(square, next)) sum += *contrast, ++count;
      }
      if (count > 0 && sum / count > clear) return true;
    }
  return false;
}

// Row by row, lying as `inner` does; empty if the squares are not such a board's.
std::vector<cv::Point2f> corners_of(const cv::Mat& levels, const Lattice& lattice, const LatticeGrower& grower,
                                    const cv::Size& inner) {
  const Bounds bounds = bounds_of(lattice);
  const bool lying = bounds.side(0) == inner.width + 1 && bounds.side(1) == inner.height + 1;
  const bool standing = bounds.side(0) == inner.height + 1 && bounds.side(1) == inner.width + 1;
  const int black = (inner.width + 1) * (inner.height + 1) / 2;
  if ((!lying && !standing) || static_cast<double>(lattice.size()) < kLeastFound * black) return {};
  const SquareLevels squares(levels, grower.placed(lattice));
  if (!is_a_board(squares, bounds, kAsClear * grower.contrast())) return {};
  if (goes_on(squares, bounds, kGoesOn * grower.contrast())) return {};
  std::vector<cv::Point2f> corners;
  for (int row = 0; row < inner.height; ++row)
    for (int column = 0; column < inner.width; ++column) {
      const auto pixel =
          squares.pixel(at(bounds.low) + Eigen::Vector2d((lying ? column : row) + 0.5, (lying ? row : column) + 0.5));
      if (!pixel) return {};
      corners.emplace_back(static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
    }
  return corners;
}

std::vector<cv::Point2f> find_at_blur(const cv::Mat& grey, const cv::Mat& levels, double blur, const cv::Size& inner) {
  const auto blobs = dark_blobs(grey, blur);
  LatticeGrower grower(levels, blobs, kLargestSquare * blur);
  // Squares at a board's rim, which have not all four neighbours, may start a slanting lattice: others will not.
  for (std::size_t seed = 0; seed < blobs.size(); ++seed) {
    auto lattice = grower.grown_from(seed);
    trim(lattice);
    if (lattice.empty()) continue;
    auto corners = corners_of(levels, lattice, grower, inner);
    if (!corners.empty()) return corners;
  }
  return {};
}

}  // namespace

std::optional<std::vector<cv::Point2f>> find_square_lattice(const cv::Mat& grey, const cv::Size& inner) {
  const cv::Mat levels = smoothed(grey, kLevelBlur);
  for (const double blur : kBlurs)
    if (auto corners = find_at_blur(grey, levels, blur, inner); !corners.empty()) return corners;
  return std::nullopt;
}

}  // namespace rotunda::capture
