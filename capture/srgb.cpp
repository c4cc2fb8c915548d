#include "capture/srgb.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace rotunda::capture {
namespace {

constexpr int kSteps = 4096;  // linear light; the curve's steepest part then moves a third of a level a step

const std::array<std::uint8_t, kSteps + 1>& code_table() {
  static const auto table = [] {
    std::array<std::uint8_t, kSteps + 1> codes{};
    for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = srgb8_of(static_cast<double>(i) / kSteps);
    return codes;
  }();
  return table;
}

}  // namespace

double linear_of_srgb(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double srgb_of_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

const std::array<float, 256>& linear_table() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>(linear_of_srgb(static_cast<double>(i) / 255.0));
    return values;
  }();
  return table;
}

std::uint8_t srgb8_of(double linear) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(srgb_of_linear(linear), 0.0, 1.0)));
}

cv::Mat with_matrix(const cv::Mat& rgb, const Eigen::Matrix3d& matrix) {
  if (matrix == Eigen::Matrix3d::Identity()) return rgb.clone();
  const auto& codes = code_table();
  const auto& table = linear_table();
  const Eigen::Matrix3f m = matrix.cast<float>() * static_cast<float>(kSteps);
  cv::Mat result(rgb.size(), CV_8UC3);
  for (int y = 0; y < rgb.rows; ++y) {
    const auto* from = rgb.ptr<cv::Vec3b>(y);
    auto* to = result.ptr<cv::Vec3b>(y);
    for (int x = 0; x < rgb.cols; ++x) {
      const Eigen::Vector3f light = m * Eigen::Vector3f(table[from[x][0]], table[from[x][1]], table[from[x][2]]);
      for (int c = 0; c < 3; ++c)
        to[x][c] = codes[static_cast<std::size_t>(std::clamp(light[c] + 0.5F, 0.0F, static_cast<float>(kSteps)))];
    }
  }
  return result;
}

}  // namespace rotunda::capture
