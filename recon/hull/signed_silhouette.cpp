#include "recon/hull/signed_silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

constexpr float kHalf = 127.5F;
constexpr int kAround = 32;  // pixels about the performer with distances that are nearly exact

struct Segment {
  cv::Point2f a, b;
};

float distance_to(const Segment& s, cv::Point2f p) {
  const cv::Point2f along = s.b - s.a, from = p - s.a;
  const float length2 = along.dot(along);
  const float t = length2 > 0.0F ? std::clamp(from.dot(along) / length2, 0.0F, 1.0F) : 0.0F;
  const cv::Point2f rest = from - t * along;
  return std::sqrt(rest.dot(rest));
}

// The contour within the square of pixel centres (x..x+1, y..y+1): one or two segments. On a saddle the square's mean
// decides which diagonal is joined.
void add_segments(const cv::Mat& alpha, int x, int y, std::vector<Segment>& segments) {
  constexpr std::array<std::array<int, 2>, 4> kCorner{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  std::array<float, 4> value;
  for (std::size_t i = 0; i < 4; ++i)
    value[i] = static_cast<float>(alpha.at<std::uint8_t>(y + kCorner[i][1], x + kCorner[i][0])) - kHalf;
  std::array<cv::Point2f, 4> crossing;
  std::array<std::size_t, 4> side{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    if ((value[i] > 0.0F) == (value[j] > 0.0F)) continue;
    const float t = value[i] / (value[i] - value[j]);
    crossing[i] =
        cv::Point2f(static_cast<float>(x + kCorner[i][0]) + t * static_cast<float>(kCorner[j][0] - kCorner[i][0]),
                    static_cast<float>(y + kCorner[i][1]) + t * static_cast<float>(kCorner[j][1] - kCorner[i][1]));
    side[count++] = i;
  }
  if (count == 2) segments.push_back({crossing[side[0]], crossing[side[1]]});
  if (count != 4) return;
  const bool joined = (value[0] + value[1] + value[2] + value[3] > 0.0F) == (value[0] > 0.0F);  // corners 0 and 2
  const std::size_t first = joined ? 1 : 3;
  segments.push_back({crossing[0], crossing[first]});
  segments.push_back({crossing[2], crossing[4 - first]});
}

std::vector<Segment> contour(const cv::Mat& alpha) {
  std::vector<Segment> segments;
  for (int y = 0; y + 1 < alpha.rows; ++y) {
    const auto* row = alpha.ptr<std::uint8_t>(y);
    const auto* below = alpha.ptr<std::uint8_t>(y + 1);
    for (int x = 0; x + 1 < alpha.cols; ++x) {
      const int inside = (row[x] > 127) + (row[x + 1] > 127) + (below[x] > 127) + (below[x + 1] > 127);
      if (inside != 0 && inside != 4) add_segments(alpha, x, y, segments);
    }
  }
  return segments;
}

// How far from the outline distances are exact, pixels, and by which of OpenCV's masks they are beyond.
struct Fineness {
  int band;
  int mask;
};

cv::Mat coarse_distance(const cv::Mat& alpha, int mask) {
  const cv::Mat inside = alpha > 127;
  cv::Mat to_outside, to_inside;
  cv::distanceTransform(inside, to_outside, cv::DIST_L2, mask, CV_32F);
  cv::distanceTransform(~inside, to_inside, cv::DIST_L2, mask, CV_32F);
  // A picture without the other side has no distance to it: OpenCV then returns huge values; the diagonal will do.
  const float diagonal = std::hypot(static_cast<float>(alpha.cols), static_cast<float>(alpha.rows));
  cv::Mat distance(alpha.size(), CV_32F);
  for (int y = 0; y < alpha.rows; ++y) {
    const auto* out = to_outside.ptr<float>(y);
    const auto* in = to_inside.ptr<float>(y);
    auto* row = distance.ptr<float>(y);
    for (int x = 0; x < alpha.cols; ++x)
      row[x] = in[x] == 0.0F ? std::min(out[x] - 0.5F, diagonal) : -std::min(in[x] - 0.5F, diagonal);
  }
  return distance;
}

void splat(const Segment& segment, int band, cv::Mat& nearest) {
  const cv::Point2f middle = 0.5F * (segment.a + segment.b);
  const int x0 = std::max(0, cvFloor(middle.x) - band), y0 = std::max(0, cvFloor(middle.y) - band);
  const int x1 = std::min(nearest.cols - 1, cvCeil(middle.x) + band);
  const int y1 = std::min(nearest.rows - 1, cvCeil(middle.y) + band);
  for (int y = y0; y <= y1; ++y) {
    auto* row = nearest.ptr<float>(y);
    for (int x = x0; x <= x1; ++x)
      row[x] = std::min(row[x], distance_to(segment, {static_cast<float>(x), static_cast<float>(y)}));
  }
}

cv::Mat exact_near_outline(const cv::Mat& alpha, const Fineness& fineness) {
  cv::Mat distance = coarse_distance(alpha, fineness.mask);
  constexpr float kFar = 1e9F;
  cv::Mat nearest(distance.size(), CV_32F, cv::Scalar(kFar));
  for (const auto& segment : contour(alpha)) splat(segment, fineness.band, nearest);
  for (int y = 0; y < distance.rows; ++y) {
    auto* row = distance.ptr<float>(y);
    const auto* exact = nearest.ptr<float>(y);
    for (int x = 0; x < distance.cols; ++x)
      if (exact[x] < static_cast<float>(fineness.band)) row[x] = std::copysign(exact[x], row[x]);
  }
  return distance;
}

void check(const capture::Matte& matte) {
  if (matte.alpha.empty() || matte.alpha.type() != CV_8UC1)
    throw InvalidInput("a matte must be an 8-bit grey picture with at least one pixel");
}

// Of pixels outside of the box, negative; the larger of the ways along the axes.
cv::Mat distance_from(const cv::Rect& box, const cv::Size& size) {
  cv::Mat distance(size, CV_32F);
  for (int y = 0; y < size.height; ++y) {
    auto* row = distance.ptr<float>(y);
    const int above_or_below = std::max({box.y - y, y - box.br().y + 1, 0});
    for (int x = 0; x < size.width; ++x)
      row[x] = 0.5F - static_cast<float>(std::max({box.x - x, x - box.br().x + 1, above_or_below}));
  }
  return distance;
}

}  // namespace

cv::Mat quick_silhouette(const capture::Matte& matte) {
  check(matte);
  return exact_near_outline(matte.alpha, {.band = 2, .mask = cv::DIST_MASK_5});
}

cv::Mat signed_silhouette(const capture::Matte& matte) {
  check(matte);
  constexpr Fineness kFine{.band = kExactBand, .mask = cv::DIST_MASK_PRECISE};
  const cv::Rect picture(0, 0, matte.alpha.cols, matte.alpha.rows), body = cv::boundingRect(matte.alpha > 127);
  if (body.empty()) return exact_near_outline(matte.alpha, kFine);
  const cv::Rect about =
      cv::Rect(body.x - kAround, body.y - kAround, body.width + 2 * kAround, body.height + 2 * kAround) & picture;
  cv::Mat distance = distance_from(body, picture.size());
  exact_near_outline(matte.alpha(about), kFine).copyTo(distance(about));
  return distance;
}

bool is_empty(const capture::Matte& matte) {
  double most = 0.0;
  cv::minMaxLoc(matte.alpha, nullptr, &most);
  return most < static_cast<double>(kHalf);
}

}  // namespace rotunda::recon
