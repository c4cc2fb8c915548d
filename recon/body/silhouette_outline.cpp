#include "recon/body/silhouette_outline.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector2d;
using Contour = std::vector<cv::Point>;

constexpr int kMargin = 40;         // of the window around the performer, half-resolution pixels
constexpr float kLevel = 127.5F;    // of the outline
constexpr float kExactBand = 1.5F;  // half-resolution pixels where the matte itself tells the distance

// Half-resolution pixel i covers 2 i and 2 i + 1.
Vector2d full_from_half(const Vector2d& half) {
  return 2.0 * half + Vector2d::Constant(0.5);
}
Vector2d half_from_full(const Vector2d& full) {
  return 0.5 * (full - Vector2d::Constant(0.5));
}

void erase_specks(cv::Mat& inside, double least_patch) {
  cv::Mat labels, stats, centres;
  const int patches = cv::connectedComponentsWithStats(inside, labels, stats, centres, 8, CV_32S);
  if (patches <= 2) return;
  int largest = 0;
  for (int i = 1; i < patches; ++i) largest = std::max(largest, stats.at<int>(i, cv::CC_STAT_AREA));
  std::vector<std::uint8_t> keep(static_cast<std::size_t>(patches), 255);
  keep[0] = 0;
  for (int i = 1; i < patches; ++i)
    if (stats.at<int>(i, cv::CC_STAT_AREA) < least_patch * largest) keep[static_cast<std::size_t>(i)] = 0;
  for (int y = 0; y < inside.rows; ++y)
    for (int x = 0; x < inside.cols; ++x)
      inside.at<std::uint8_t>(y, x) = keep[static_cast<std::size_t>(labels.at<int>(y, x))];
}

// Half-resolution pixels, positive inside; within the band from where the matte crosses its middle.
cv::Mat signed_distance(const cv::Mat& inside, const cv::Mat& alpha) {
  cv::Mat in, out, smooth, dx, dy;
  cv::distanceTransform(inside, in, cv::DIST_L2, 5, CV_32F);
  cv::distanceTransform(~inside, out, cv::DIST_L2, 5, CV_32F);
  alpha.convertTo(smooth, CV_32F);
  cv::Sobel(smooth, dx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(smooth, dy, CV_32F, 0, 1, 3, 0.125);
  cv::Mat distance(inside.size(), CV_32FC1);
  for (int y = 0; y < inside.rows; ++y)
    for (int x = 0; x < inside.cols; ++x) {
      const bool is_inside = inside.at<std::uint8_t>(y, x) != 0;
      float d = is_inside ? in.at<float>(y, x) - 0.5F : 0.5F - out.at<float>(y, x);
      const float slope = std::hypot(dx.at<float>(y, x), dy.at<float>(y, x));
      if (std::abs(d) < kExactBand && slope > 40.0F)  // of 255 a pixel: a clear edge
        d = std::clamp((smooth.at<float>(y, x) - kLevel) / slope, d - 0.5F, d + 0.5F);
      distance.at<float>(y, x) = d;
    }
  return distance;
}

bool at_border(const Vector2d& pixel, const cv::Size& picture) {
  constexpr double kBorder = 3.0;
  return pixel.x() < kBorder || pixel.y() < kBorder || pixel.x() > picture.width - 1 - kBorder ||
         pixel.y() > picture.height - 1 - kBorder;
}

// Steps along every contour; a step's point is carried onto the outline by the distance there.
void add_points(SilhouetteOutline& outline, const std::vector<Contour>& contours, double spacing_px) {
  for (const auto& contour : contours) {
    double walked = spacing_px;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const cv::Point step = contour[i] - contour[(i + contour.size() - 1) % contour.size()];
      walked += 2.0 * std::hypot(step.x, step.y);
      if (walked < spacing_px) continue;
      const Vector2d pixel = full_from_half({contour[i].x + outline.origin.x, contour[i].y + outline.origin.y});
      const auto sample = outline.sample(pixel);
      if (!sample || at_border(pixel, outline.picture) || sample->gradient.norm() < 0.3) continue;
      const Vector2d inwards = sample->gradient.normalized();
      outline.points.push_back({pixel - sample->distance_px * inwards, -inwards});
      walked = 0.0;
    }
  }
}

cv::Rect around(const cv::Rect& box, int margin, const cv::Size& size) {
  return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
         cv::Rect(cv::Point(), size);
}

}  // namespace

std::optional<SilhouetteOutline::Sample> SilhouetteOutline::sample(const Vector2d& pixel) const {
  if (is_empty() ||
      !(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < picture.width - 0.5 && pixel.y() < picture.height - 0.5))
    return std::nullopt;
  const Vector2d half = half_from_full(pixel) - Vector2d(origin.x, origin.y);
  const Vector2d inner(std::clamp(half.x(), 0.0, distance.cols - 1.001),
                       std::clamp(half.y(), 0.0, distance.rows - 1.001));
  const int x = static_cast<int>(inner.x()), y = static_cast<int>(inner.y());
  const double u = inner.x() - x, v = inner.y() - y;
  const float *top = distance.ptr<float>(y) + x, *low = distance.ptr<float>(y + 1) + x;
  const double above = top[0] + u * (top[1] - top[0]), below = low[0] + u * (low[1] - low[0]);
  Sample sample;
  sample.distance_px = 2.0 * (above + v * (below - above));
  sample.gradient = {(1.0 - v) * (top[1] - top[0]) + v * (low[1] - low[0]), below - above};
  if (const Vector2d beyond = half - inner; beyond.squaredNorm() > 1e-4) {
    sample.distance_px -= 2.0 * beyond.norm();
    sample.gradient = -beyond.normalized();
  }
  return sample;
}

SilhouetteOutline silhouette_outline(const capture::Matte& matte, const OutlineOptions& options) {
  if (matte.alpha.type() != CV_8UC1 || matte.alpha.cols < 8 || matte.alpha.rows < 8)
    throw InvalidInput("a silhouette's outline needs an 8-bit matte of 8 x 8 pixels or more");
  SilhouetteOutline outline;
  outline.picture = matte.alpha.size();
  cv::Mat half;
  cv::resize(matte.alpha, half, {matte.alpha.cols / 2, matte.alpha.rows / 2}, 0, 0, cv::INTER_AREA);
  cv::Mat inside = half > 127;
  const cv::Rect patch = cv::boundingRect(inside);
  if (patch.area() == 0) return outline;
  const cv::Rect window = around(patch, kMargin, half.size());
  inside = inside(window).clone();
  erase_specks(inside, options.least_patch);
  outline.origin = window.tl();
  outline.area = 4.0 * cv::countNonZero(inside);
  const cv::Rect kept = cv::boundingRect(inside);
  outline.box = cv::Rect(2 * (kept.x + window.x), 2 * (kept.y + window.y), 2 * kept.width, 2 * kept.height);
  outline.distance = signed_distance(inside, half(window));
  std::vector<Contour> contours;
  cv::findContours(inside, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  add_points(outline, contours, options.spacing_px);
  return outline;
}

}  // namespace rotunda::recon
