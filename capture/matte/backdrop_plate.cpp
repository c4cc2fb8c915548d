#include "capture/matte/backdrop_plate.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace rotunda::capture {
namespace {

constexpr int kOrder = 5;
constexpr int kTerms = (kOrder + 1) * (kOrder + 2) / 2;
constexpr int kStride = 8;  // every eighth pixel both ways is plenty for 21 coefficients a channel
constexpr double kLeastShare = 0.02;
// A pixel is backdrop-coloured if its channel leads both others by a sixth; blue paint leads by a third and more even
// where little light falls, skin and cloth other than blue do not lead at all.
constexpr float kLead = 1.17F;
constexpr float kLeastLight = 12.0F;  // grey levels; below it no hue can be told from noise

using Terms = Eigen::Matrix<double, kTerms, 1>;
using Coefficients = Eigen::Matrix<double, kTerms, 3>;

struct Sample {
  Terms terms;
  Eigen::Vector3d log_colour;
};

bool is_backdrop(const cv::Vec3b& pixel, Backdrop backdrop) {
  const std::size_t own = backdrop == Backdrop::blue ? 2 : 1;
  const float value = pixel[static_cast<int>(own)];
  if (value < kLeastLight) return false;
  for (int channel = 0; channel < 3; ++channel)
    if (channel != static_cast<int>(own) && value < kLead * static_cast<float>(pixel[channel])) return false;
  return true;
}

const std::array<float, 256>& log_table() {
  static const auto table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::log(static_cast<float>(i) + kLogOffset);
    return values;
  }();
  return table;
}

Terms terms_at(double x, double y, const cv::Size& size) {
  const double u = 2.0 * x / size.width - 1.0, v = 2.0 * y / size.height - 1.0;
  Terms terms;
  int at = 0;
  double up = 1.0;
  for (int i = 0; i <= kOrder; ++i, up *= u) {
    double vp = 1.0;
    for (int j = 0; i + j <= kOrder; ++j, vp *= v) terms[at++] = up * vp;
  }
  return terms;
}

std::vector<Sample> backdrop_samples(const cv::Mat& rgb, Backdrop backdrop) {
  std::vector<Sample> samples;
  for (int y = kStride / 2; y < rgb.rows; y += kStride)
    for (int x = kStride / 2; x < rgb.cols; x += kStride) {
      const auto& pixel = rgb.at<cv::Vec3b>(y, x);
      if (!is_backdrop(pixel, backdrop)) continue;
      const auto& logs = log_table();
      samples.push_back({terms_at(x, y, rgb.size()), {logs[pixel[0]], logs[pixel[1]], logs[pixel[2]]}});
    }
  return samples;
}

// The ridge keeps the polynomial tame in corners that no backdrop pixel reaches.
Coefficients fit(const std::vector<Sample>& samples, const Coefficients& before, double most_residual) {
  Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Identity() * 1e-3;
  Coefficients right = Coefficients::Zero();
  for (const auto& sample : samples) {
    const Eigen::Vector3d residual = sample.log_colour - before.transpose() * sample.terms;
    if (residual.cwiseAbs().maxCoeff() > most_residual) continue;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(sample.terms);
    right += sample.terms * sample.log_colour.transpose();
  }
  return normal.selfadjointView<Eigen::Lower>().ldlt().solve(right);
}

Coefficients robust_fit(const std::vector<Sample>& samples) {
  Coefficients coefficients = fit(samples, Coefficients::Zero(), 1e9);
  for (const double most_residual : {0.5, 0.25, 0.25, 0.12, 0.12})
    coefficients = fit(samples, coefficients, most_residual);
  return coefficients;
}

}  // namespace

std::optional<Backdrop> backdrop_of(const cv::Mat& rgb) {
  const double blue = backdrop_share(rgb, Backdrop::blue), green = backdrop_share(rgb, Backdrop::green);
  if (std::max(blue, green) < kLeastShare) return std::nullopt;
  return blue >= green ? Backdrop::blue : Backdrop::green;
}

bool is_before_screen(const cv::Mat& plate, Backdrop backdrop, const cv::Mat& stage) {
  constexpr int kMean = 8;
  const cv::Size size(std::max(1, plate.cols / kMean), std::max(1, plate.rows / kMean));
  cv::Mat means, here(size, CV_8UC1, cv::Scalar(255));
  cv::resize(plate, means, size, 0, 0, cv::INTER_AREA);
  if (!stage.empty()) cv::resize(stage, here, size, 0, 0, cv::INTER_NEAREST);
  int screen = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      screen += here.at<std::uint8_t>(y, x) != 0 && is_backdrop(means.at<cv::Vec3b>(y, x), backdrop) ? 1 : 0;
  return 2 * screen > cv::countNonZero(here);
}

KeyChannels key_channels(const cv::Mat& plate, Backdrop backdrop) {
  const int own = backdrop == Backdrop::blue ? 2 : 1, third = 3 - own;
  const cv::Scalar mean = cv::mean(plate);
  return mean[0] <= mean[third] ? KeyChannels{own, 0, third} : KeyChannels{own, third, 0};
}

double backdrop_share(const cv::Mat& rgb, Backdrop backdrop) {
  int samples = 0;
  for (int y = kStride / 2; y < rgb.rows; y += kStride)
    for (int x = kStride / 2; x < rgb.cols; x += kStride) samples += is_backdrop(rgb.at<cv::Vec3b>(y, x), backdrop);
  return static_cast<double>(samples) * kStride * kStride / static_cast<double>(rgb.total());
}

cv::Mat backdrop_mask(const cv::Mat& rgb, Backdrop backdrop) {
  cv::Mat mask(rgb.size(), CV_8UC1);
  std::transform(rgb.begin<cv::Vec3b>(), rgb.end<cv::Vec3b>(), mask.begin<std::uint8_t>(),
                 [&](const cv::Vec3b& pixel) -> std::uint8_t { return is_backdrop(pixel, backdrop) ? 255 : 0; });
  return mask;
}

cv::Mat fit_plate(const cv::Mat& rgb, Backdrop backdrop) {
  const auto samples = backdrop_samples(rgb, backdrop);
  if (static_cast<double>(samples.size()) * kStride * kStride < kLeastShare * static_cast<double>(rgb.total()))
    return {};
  const Coefficients coefficients = robust_fit(samples);
  // The plate is smooth: evaluated on a coarse grid and interpolated it is the same and a hundred times cheaper.
  cv::Mat plate(rgb.size(), CV_32FC3);
  for (int y = 0; y < rgb.rows; ++y) {
    auto* row = plate.ptr<cv::Vec3f>(y);
    Eigen::Vector3f next = (coefficients.transpose() * terms_at(0, y, rgb.size())).cast<float>();
    for (int x = 0; x < rgb.cols; x += 8) {
      const Eigen::Vector3f here = next;
      next = (coefficients.transpose() * terms_at(x + 8, y, rgb.size())).cast<float>();
      for (int k = 0; k < 8 && x + k < rgb.cols; ++k) {
        const Eigen::Vector3f value = here + (next - here) * (static_cast<float>(k) / 8.0F);
        row[x + k] = {value[0], value[1], value[2]};
      }
    }
  }
  return plate;
}

cv::Mat fit_plate_picture(const cv::Mat& rgb, Backdrop backdrop) {
  const cv::Mat logs = fit_plate(rgb, backdrop);
  return logs.empty() ? cv::Mat() : picture_of_log(logs);
}

cv::Mat picture_of_log(const cv::Mat& logs) {
  cv::Mat values, bytes;
  cv::exp(logs, values);
  values.convertTo(bytes, CV_8U, 1.0, -kLogOffset);
  return bytes;
}

cv::Mat log_picture(const cv::Mat& rgb) {
  cv::Mat result(rgb.size(), CV_32FC3);
  const auto& logs = log_table();
  for (int y = 0; y < rgb.rows; ++y) {
    const auto* from = rgb.ptr<cv::Vec3b>(y);
    auto* to = result.ptr<cv::Vec3f>(y);
    for (int x = 0; x < rgb.cols; ++x) to[x] = {logs[from[x][0]], logs[from[x][1]], logs[from[x][2]]};
  }
  return result;
}

cv::Scalar light_change(const cv::Mat& log_rgb, const cv::Mat& log_plate, Backdrop backdrop) {
  const int own = backdrop == Backdrop::blue ? 2 : 1;
  const float lead = std::log(kLead);
  std::array<std::vector<float>, 3> changes;
  for (int y = kStride / 2; y < log_rgb.rows; y += kStride)
    for (int x = kStride / 2; x < log_rgb.cols; x += kStride) {
      const auto& pixel = log_rgb.at<cv::Vec3f>(y, x);
      if (pixel[own] < std::max(pixel[(own + 1) % 3], pixel[(own + 2) % 3]) + lead) continue;
      const cv::Vec3f change = pixel - log_plate.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c) changes[static_cast<std::size_t>(c)].push_back(change[c]);
    }
  if (static_cast<double>(changes[0].size()) * kStride * kStride < kLeastShare * static_cast<double>(log_rgb.total()))
    return {};
  cv::Scalar medians;
  for (std::size_t c = 0; c < changes.size(); ++c) {
    const auto middle = changes[c].begin() + static_cast<std::ptrdiff_t>(changes[c].size() / 2);
    std::nth_element(changes[c].begin(), middle, changes[c].end());
    medians[static_cast<int>(c)] = *middle;
  }
  return medians;
}

}  // namespace rotunda::capture
