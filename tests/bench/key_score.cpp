#include "tests/bench/key_score.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "recon/hull/signed_silhouette.h"

namespace rotunda::bench {
namespace {

constexpr float kFar = 20.0F;  // pixels; what is farther is another piece and counts so much
constexpr int kRim = 4;        // pixels

// Signed distance to the other outline at the sub-pixel crossings of one matte.
void append_crossings(const cv::Mat& alpha, const cv::Mat& other, float sign, std::vector<float>& distances) {
  const auto cross = [&](int x, int y, int dx, int dy) {
    const float a = static_cast<float>(alpha.at<std::uint8_t>(y, x)) - 127.5F;
    const float b = static_cast<float>(alpha.at<std::uint8_t>(y + dy, x + dx)) - 127.5F;
    if ((a < 0) == (b < 0)) return;
    const float s = a / (a - b);
    const float there = (1 - s) * other.at<float>(y, x) + s * other.at<float>(y + dy, x + dx);
    distances.push_back(sign * std::clamp(there, -kFar, kFar));
  };
  for (int y = 0; y + 1 < alpha.rows; ++y)
    for (int x = 0; x + 1 < alpha.cols; ++x) cross(x, y, 1, 0), cross(x, y, 0, 1);
}

}  // namespace

MatteScore matte_score(const cv::Mat& found, const cv::Mat& truth) {
  const cv::Mat a = found >= 128, b = truth >= 128;
  MatteScore score;
  append_crossings(found, recon::signed_silhouette({truth}), -1.0F, score.distances);
  append_crossings(truth, recon::signed_silhouette({found}), 1.0F, score.distances);
  score.overlap = cv::countNonZero(a & b) / std::max(1.0, static_cast<double>(cv::countNonZero(a | b)));
  return score;
}

cv::Mat rim_mask(const cv::Mat& truth_matte) {
  const cv::Mat depth = recon::signed_silhouette({truth_matte});
  return (depth >= 0.0) & (depth <= kRim);
}

double rim_colour_error(const cv::Mat& colours, const cv::Mat& truth_colours, const cv::Mat& truth_matte) {
  const cv::Mat rim = rim_mask(truth_matte);
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < rim.rows; ++y)
    for (int x = 0; x < rim.cols; ++x) {
      if (rim.at<std::uint8_t>(y, x) == 0) continue;
      for (int c = 0; c < 3; ++c)
        sum += std::abs(colours.at<cv::Vec3b>(y, x)[c] - truth_colours.at<cv::Vec3b>(y, x)[c]);
      count += 3;
    }
  return count == 0 ? -1.0 : sum / count;
}

void MatteTotals::add(const MatteScore& score) {
  overlaps_.push_back(score.overlap);
  distances_.insert(distances_.end(), score.distances.begin(), score.distances.end());
}

void MatteTotals::add(const MatteTotals& other) {
  overlaps_.insert(overlaps_.end(), other.overlaps_.begin(), other.overlaps_.end());
  distances_.insert(distances_.end(), other.distances_.begin(), other.distances_.end());
}

double MatteTotals::overlap() const {
  return std::accumulate(overlaps_.begin(), overlaps_.end(), 0.0) /
         std::max(1.0, static_cast<double>(overlaps_.size()));
}

double MatteTotals::worst_overlap() const {
  return overlaps_.empty() ? 0.0 : *std::min_element(overlaps_.begin(), overlaps_.end());
}

double MatteTotals::edge() const {
  double sum = 0.0;
  for (const float d : distances_) sum += std::abs(static_cast<double>(d));
  return sum / std::max(1.0, static_cast<double>(distances_.size()));
}

double MatteTotals::edge_quantile(double share) const {
  if (distances_.empty()) return 0.0;
  std::vector<float> sizes(distances_);
  for (float& d : sizes) d = std::abs(d);
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

double MatteTotals::bias() const {
  double sum = 0.0;
  std::size_t count = 0;
  for (const float d : distances_)
    if (std::abs(d) < 2.0F) sum += d, ++count;
  return sum / std::max(1.0, static_cast<double>(count));
}

}  // namespace rotunda::bench
