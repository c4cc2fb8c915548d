#include "capture/calibration/lattice_growth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace rotunda::capture {
namespace {

constexpr double kLeastDarkness = 0.5;   // grey levels a pixel^2: above sensors' noise after the blur
constexpr std::size_t kMostBlobs = 800;  // the darkest of them; a board has fewer than a hundred
constexpr double kLeastContrast = 15.0;  // grey levels between white and black squares
constexpr double kAsDark = 0.35;         // of the first square's darkness
constexpr std::size_t kNeighbours = 14;  // a square's four are among its nearest blobs
constexpr double kMidway = 0.2;          // of the distance between neighbours: perspective and blobs' errors
constexpr double kApart = 0.2;           // sine, 12 degrees: between a board's two diagonals
constexpr double kWithin = 0.3;          // of the distance between neighbours: about where one is foretold

// Of the board for sure: a margin need not be white.
bool borders_on_another(const Lattice& lattice, const Place& white) {
  return std::any_of(kSides.begin(), kSides.end(), [&](const auto& side) { return lattice.contains(white + side); });
}

}  // namespace

cv::Mat smoothed(const cv::Mat& grey, double blur_px) {
  cv::Mat smooth;
  grey.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, blur_px);
  return smooth;
}

std::vector<Blob> dark_blobs(const cv::Mat& grey, double blur_px) {
  cv::Mat darkness, highest;
  cv::Laplacian(smoothed(grey, blur_px), darkness, CV_32F);
  const int window = 2 * static_cast<int>(std::lround(blur_px)) + 1;
  cv::dilate(darkness, highest, cv::Mat::ones(window, window, CV_8U));
  std::vector<Blob> blobs;
  for (int y = 1; y + 1 < grey.rows; ++y)
    for (int x = 1; x + 1 < grey.cols; ++x) {
      const float value = darkness.at<float>(y, x);
      if (value >= kLeastDarkness && value == highest.at<float>(y, x)) blobs.push_back({{x, y}, value});
    }
  std::stable_sort(blobs.begin(), blobs.end(), [](const auto& a, const auto& b) { return a.darkness > b.darkness; });
  blobs.resize(std::min(blobs.size(), kMostBlobs));
  return blobs;
}

Eigen::Vector2d carried(const Eigen::Matrix3d& pixel_from_place, const Eigen::Vector2d& place) {
  return (pixel_from_place * place.homogeneous()).hnormalized();
}

Lattice LatticeGrower::grown_from(std::size_t seed) {
  Lattice lattice = started(seed);
  std::set<std::size_t> taken;
  for (const auto& [place, blob] : lattice) taken.insert(blob);
  while (!lattice.empty() && grow_round(lattice, taken)) {
  }
  return lattice;
}

std::vector<PlacedPoint> LatticeGrower::placed(const Lattice& lattice) const {
  std::vector<PlacedPoint> points;
  for (const auto& [place, blob] : lattice) points.push_back({at(place), blobs_[blob].pixel});
  return points;
}

std::vector<std::size_t> LatticeGrower::nearest_to(std::size_t seed) const {
  std::vector<std::pair<double, std::size_t>> others;
  for (std::size_t i = 0; i < blobs_.size(); ++i)
    if (i != seed) others.emplace_back((blobs_[i].pixel - blobs_[seed].pixel).squaredNorm(), i);
  const auto count = std::min(others.size(), kNeighbours);
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count), others.end());
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < count; ++i) near.push_back(others[i].second);
  return near;
}

// Pairs of near blobs between which `seed` lies midway.
std::vector<LatticeGrower::Line> LatticeGrower::lines_through(std::size_t seed) const {
  const auto near = nearest_to(seed);
  const auto off = [&](std::size_t i) -> Eigen::Vector2d { return blobs_[near[i]].pixel - blobs_[seed].pixel; };
  std::vector<Line> lines;
  for (std::size_t i = 0; i < near.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if ((off(i) + off(j)).norm() < kMidway * (off(i).norm() + off(j).norm())) lines.push_back({near[i], near[j]});
  return lines;
}

// The two diagonals with the clearest squares about the seed.
Lattice LatticeGrower::started(std::size_t seed) {
  const auto lines = lines_through(seed);
  Lattice best;
  contrast_ = kLeastContrast;
  darkness_ = blobs_[seed].darkness;
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector2d a = 0.5 * (blobs_[lines[i].ahead].pixel - blobs_[lines[i].behind].pixel),
                            b = 0.5 * (blobs_[lines[j].ahead].pixel - blobs_[lines[j].behind].pixel);
      const double two_squares = std::abs(a.x() * b.y() - a.y() * b.x());
      if (two_squares < kApart * a.norm() * b.norm() || two_squares > 2.0 * largest_ * largest_) continue;
      const Lattice lattice{{{0, 0}, seed},
                            {{1, 1}, lines[i].ahead},
                            {{-1, -1}, lines[i].behind},
                            {{1, -1}, lines[j].ahead},
                            {{-1, 1}, lines[j].behind}};
      const double least = least_contrast(lattice, 0.5 * (a + b), 0.5 * (a - b));
      if (least <= contrast_) continue;
      contrast_ = least;
      best = lattice;
    }
  return best;
}

// Of the five black squares against the four white ones between them; nothing if either differ among themselves by
// more.
double LatticeGrower::least_contrast(const Lattice& lattice, const Eigen::Vector2d& right,
                                     const Eigen::Vector2d& down) const {
  const Eigen::Vector2d middle = blobs_[lattice.at({0, 0})].pixel;
  std::vector<double> black, white;
  for (const auto& [place, blob] : lattice) black.push_back(level(blobs_[blob].pixel));
  for (const auto& side : kSides) white.push_back(level(middle + side[0] * right + side[1] * down));
  const auto [blackest, lightest_black] = std::minmax_element(black.begin(), black.end());
  const auto [darkest_white, whitest] = std::minmax_element(white.begin(), white.end());
  const double contrast = *darkest_white - *lightest_black;
  return std::max(*lightest_black - *blackest, *whitest - *darkest_white) < contrast ? contrast : 0.0;
}

bool LatticeGrower::grow_round(Lattice& lattice, std::set<std::size_t>& taken) const {
  std::set<Place> rim;
  for (const auto& [place, blob] : lattice)
    for (const auto& way : kDiagonals)
      if (!lattice.contains(place + way)) rim.insert(place + way);
  const auto points = placed(lattice);
  bool grown = false;
  for (const auto& place : rim) {
    const auto H = local_homography(points, at(place), kForetoldBy);
    if (!H || !is_black_among_white(*H, place, lattice)) continue;
    const auto found = square_at(*H, place, taken);
    if (!found) continue;
    lattice[place] = *found;
    taken.insert(*found);
    grown = true;
  }
  return grown;
}

// Of the white squares beside it those count that are the board's for sure.
bool LatticeGrower::is_black_among_white(const Eigen::Matrix3d& H, const Place& place, const Lattice& lattice) const {
  const double black = level(carried(H, at(place)));
  return std::all_of(kSides.begin(), kSides.end(), [&](const auto& side) {
    const Place white = place + side;
    return !borders_on_another(lattice, white) || level(carried(H, at(white))) - black > kAsClear * contrast_;
  });
}

std::optional<std::size_t> LatticeGrower::square_at(const Eigen::Matrix3d& H, const Place& place,
                                                    const std::set<std::size_t>& taken) const {
  const Eigen::Vector2d here = carried(H, at(place));
  double nearest = kWithin * std::min((carried(H, at(place + kDiagonals[0])) - here).norm(),
                                      (carried(H, at(place + kDiagonals[2])) - here).norm());
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < blobs_.size(); ++i) {
    const double off = (blobs_[i].pixel - here).norm();
    if (off >= nearest || taken.contains(i) || blobs_[i].darkness < kAsDark * darkness_) continue;
    best = i, nearest = off;
  }
  return best;
}

double LatticeGrower::level(const Eigen::Vector2d& pixel) const {
  const int column = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, levels_.cols - 1);
  const int row = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, levels_.rows - 1);
  return levels_.at<float>(row, column);
}

}  // namespace rotunda::capture
