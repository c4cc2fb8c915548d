#include "capture/picture_health.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace rotunda::capture {
namespace {

constexpr int kClipped = 250;  // of 255: demosaicing leaves an end's neighbours just below it
constexpr int kFine = 2, kCoarse = 8;
constexpr int kRowStep = 2;
// A mean squared difference over 8 pixels of less is a bare wall.
constexpr double kLeastDetail = 2.0;

double clipped_share(const cv::Mat& rgb) {
  std::size_t clipped = 0, seen = 0;
  for (int y = 0; y < rgb.rows; y += kRowStep)
    for (int x = 0; x < rgb.cols; ++x, ++seen) {
      const auto& pixel = rgb.at<cv::Vec3b>(y, x);
      if (std::max({pixel[0], pixel[1], pixel[2]}) >= kClipped) ++clipped;
    }
  return seen == 0 ? 0.0 : static_cast<double>(clipped) / static_cast<double>(seen);
}

// Green's differences over `distance` pixels: how often each size.
std::array<std::size_t, 256> differences(const cv::Mat& rgb, int distance) {
  std::array<std::size_t, 256> histogram{};
  for (int y = 0; y < rgb.rows; y += kRowStep)
    for (int x = 0; x + distance < rgb.cols; ++x) {
      const int difference = rgb.at<cv::Vec3b>(y, x)[1] - rgb.at<cv::Vec3b>(y, x + distance)[1];
      ++histogram[static_cast<std::size_t>(std::abs(difference))];
    }
  return histogram;
}

double mean_square(const std::array<std::size_t, 256>& histogram) {
  double sum = 0.0, count = 0.0;
  for (std::size_t d = 0; d < histogram.size(); ++d) {
    sum += static_cast<double>(histogram[d] * d * d);
    count += static_cast<double>(histogram[d]);
  }
  return count > 0.0 ? sum / count : 0.0;
}

// Most of a studio's picture is smooth: there a difference is noise, and its lower quartile stays clear of edges
// (0.3186 standard deviations of a normal distribution). Whole numbers, so the quartile is interpolated in its bin.
double noise_square(const std::array<std::size_t, 256>& histogram) {
  double total = 0.0;
  for (const auto count : histogram) total += static_cast<double>(count);
  double below = 0.0;
  for (std::size_t d = 0; d < histogram.size(); ++d) {
    const auto here = static_cast<double>(histogram[d]);
    if (below + here >= 0.25 * total && here > 0.0) {
      const double width = d == 0 ? 0.5 : 1.0, from = d == 0 ? 0.0 : static_cast<double>(d) - 0.5;
      const double sigma = (from + width * (0.25 * total - below) / here) / 0.3186;
      return sigma * sigma;
    }
    below += here;
  }
  return 0.0;
}

double focus_of(const cv::Mat& rgb) {
  const auto fine = differences(rgb, kFine);
  const double noise = noise_square(fine);
  const double near = mean_square(fine) - noise, far = mean_square(differences(rgb, kCoarse)) - noise;
  if (far < kLeastDetail || near <= 0.0) return 0.0;
  const double growth = std::log(far / near) / std::log(static_cast<double>(kCoarse) / kFine);  // 1 sharp, 2 blurred
  return std::clamp(2.0 - growth, 0.0, 1.0);
}

}  // namespace

PictureHealth picture_health(const cv::Mat& rgb) {
  return {.clipped = clipped_share(rgb), .focus = focus_of(rgb)};
}

}  // namespace rotunda::capture
