#include "recon/hull/convex_outline.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr double kHalf = 127.5;
constexpr int kBorder = 2;            // pixels at the picture's border that demosaicing guesses
constexpr double kLeastPiece = 0.02;  // of the largest piece's area

// 255 where the large pieces are, and a pixel around them for their soft rim.
cv::Mat large_pieces(const cv::Mat& alpha) {
  cv::Mat labels, statistics, centroids;
  const cv::Mat inside = alpha > kHalf;
  const int count = cv::connectedComponentsWithStats(inside, labels, statistics, centroids);
  const auto area = [&](int label) { return statistics.at<int>(label, cv::CC_STAT_AREA); };
  int largest = 0;
  for (int label = 1; label < count; ++label) largest = std::max(largest, area(label));
  std::vector<std::uint8_t> keep(static_cast<std::size_t>(count), 0);
  for (int label = 1; label < count; ++label)
    keep[static_cast<std::size_t>(label)] = area(label) >= kLeastPiece * largest;
  cv::Mat kept(alpha.size(), CV_8UC1);
  for (int y = 0; y < alpha.rows; ++y)
    for (int x = 0; x < alpha.cols; ++x)
      kept.at<std::uint8_t>(y, x) = keep[static_cast<std::size_t>(labels.at<int>(y, x))] != 0 ? 255 : 0;
  cv::dilate(kept, kept, cv::Mat());
  return kept;
}

bool reaches_border(const cv::Mat& mask) {
  const cv::Rect inner(kBorder, kBorder, mask.cols - 2 * kBorder, mask.rows - 2 * kBorder);
  return inner.width <= 0 || inner.height <= 0 || cv::countNonZero(mask) != cv::countNonZero(mask(inner));
}

// Where the contour crosses the lines between neighbouring pixels: of each row, then of each column, the outermost.
std::vector<Eigen::Vector2d> outermost_crossings(const cv::Mat& alpha) {
  std::vector<Eigen::Vector2d> crossings;
  const auto value = [&](int x, int y) { return static_cast<double>(alpha.at<std::uint8_t>(y, x)); };
  const auto share = [&](double outside, double inside) { return (kHalf - outside) / (inside - outside); };
  for (int y = 0; y < alpha.rows; ++y) {
    int first = 0, last = alpha.cols - 1;
    while (first < alpha.cols && value(first, y) < kHalf) ++first;
    if (first == alpha.cols) continue;
    while (value(last, y) < kHalf) --last;
    crossings.emplace_back(first == 0 ? 0.0 : first - 1.0 + share(value(first - 1, y), value(first, y)), y);
    crossings.emplace_back(last + 1 == alpha.cols ? last : last + 1.0 - share(value(last + 1, y), value(last, y)), y);
  }
  for (int x = 0; x < alpha.cols; ++x) {
    int first = 0, last = alpha.rows - 1;
    while (first < alpha.rows && value(x, first) < kHalf) ++first;
    if (first == alpha.rows) continue;
    while (value(x, last) < kHalf) --last;
    crossings.emplace_back(x, first == 0 ? 0.0 : first - 1.0 + share(value(x, first - 1), value(x, first)));
    crossings.emplace_back(x, last + 1 == alpha.rows ? last : last + 1.0 - share(value(x, last + 1), value(x, last)));
  }
  return crossings;
}

}  // namespace

ConvexOutline convex_outline(const capture::CameraModel& camera, const capture::Matte& matte) {
  if (matte.alpha.cols != camera.width || matte.alpha.rows != camera.height || matte.alpha.type() != CV_8UC1)
    throw InvalidInput(fmt::format("{}: the matte has {} x {} pixels, the calibration says {} x {}", camera.name,
                                   matte.alpha.cols, matte.alpha.rows, camera.width, camera.height));
  const cv::Mat pieces = large_pieces(matte.alpha);
  cv::Mat alpha = cv::Mat::zeros(matte.alpha.size(), CV_8UC1);
  matte.alpha.copyTo(alpha, pieces);
  ConvexOutline outline{.corners = {}, .is_cut = reaches_border(pieces)};
  const Eigen::Matrix3d ideal_from_pixel = camera.K.inverse();
  std::vector<cv::Point2f> points;
  for (const auto& pixel : outermost_crossings(alpha))
    if (const auto ideal = capture::undistort(camera, (ideal_from_pixel * pixel.homogeneous()).head<2>()))
      points.emplace_back(static_cast<float>(ideal->x()), static_cast<float>(ideal->y()));
  if (points.size() < 3) return outline;
  std::vector<cv::Point2f> hull;
  cv::convexHull(points, hull);
  for (const auto& corner : hull) outline.corners.emplace_back(corner.x, corner.y);
  return outline;
}

}  // namespace rotunda::recon
