#pragma once
// Lattices of black squares, grown from blobs: the first half of square_lattice.h.
#include <array>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <vector>

#include "capture/calibration/board_detector.h"

namespace rotunda::capture {

// A dark spot of about the blur's size.
struct Blob {
  Eigen::Vector2d pixel;
  double darkness = 0.0;  // the Laplacian of the smoothed picture, grey levels a pixel^2
};

// CV_8UC1 to CV_32FC1.
cv::Mat smoothed(const cv::Mat& grey, double blur_px);
// The darkest first, a few hundred at most.
std::vector<Blob> dark_blobs(const cv::Mat& grey, double blur_px);

// Column and row of a square; their sum is even for black ones. Any origin.
using Place = std::array<int, 2>;
inline constexpr std::array<Place, 4> kDiagonals = {{{1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
inline constexpr std::array<Place, 4> kSides = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
inline Place operator+(const Place& a, const Place& b) {
  return {a[0] + b[0], a[1] + b[1]};
}
inline Eigen::Vector2d at(const Place& place) {
  return {place[0], place[1]};
}
// Which blob is the black square there.
using Lattice = std::map<Place, std::size_t>;

inline constexpr double kAsClear = 0.35;  // of the first square's contrast: every square of a board has it

// Homographies from places to pixels hold about this many squares.
inline constexpr std::size_t kForetoldBy = 9;
Eigen::Vector2d carried(const Eigen::Matrix3d& pixel_from_place, const Eigen::Vector2d& place);

class LatticeGrower {
 public:
  // `levels`: the picture, CV_32FC1; squares of `largest` pixels of side at most. Both are kept by reference.
  LatticeGrower(const cv::Mat& levels, const std::vector<Blob>& blobs, double largest)
      : levels_(levels), blobs_(blobs), largest_(largest) {}

  // Empty if the blob does not look like one of many.
  Lattice grown_from(std::size_t seed);
  double contrast() const { return contrast_; }  // about the last seed, grey levels
  std::vector<PlacedPoint> placed(const Lattice& lattice) const;

 private:
  struct Line {
    std::size_t ahead, behind;
  };
  std::vector<std::size_t> nearest_to(std::size_t seed) const;
  std::vector<Line> lines_through(std::size_t seed) const;
  Lattice started(std::size_t seed);
  double least_contrast(const Lattice& lattice, const Eigen::Vector2d& right, const Eigen::Vector2d& down) const;
  bool grow_round(Lattice& lattice, std::set<std::size_t>& taken) const;
  bool is_black_among_white(const Eigen::Matrix3d& H, const Place& place, const Lattice& lattice) const;
  std::optional<std::size_t> square_at(const Eigen::Matrix3d& H, const Place& place,
                                       const std::set<std::size_t>& taken) const;
  double level(const Eigen::Vector2d& pixel) const;

  const cv::Mat& levels_;
  const std::vector<Blob>& blobs_;
  double largest_;
  double contrast_ = 0.0, darkness_ = 0.0;  // of the last seed
};

}  // namespace rotunda::capture
