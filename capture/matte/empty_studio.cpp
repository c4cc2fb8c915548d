#include "capture/matte/empty_studio.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr std::size_t kMostPictures = 256;
// A still pixel's deviation over a few dozen pictures stays within half of its neighbours'; eight-bit steps add up to
// half a level.
constexpr double kMovingAbove = 3.0, kStep = 0.5;
constexpr int kLevels = 16;             // of brightness: shot noise grows with it
constexpr double kFewestShare = 0.005;  // of the pixels; a level with fewer has no measure of its own

cv::Mat deviation_in_time(const cv::Mat& green_mean, const cv::Mat& green_squares, std::size_t pictures) {
  cv::Mat mean_square, variance, deviation;
  green_squares.convertTo(mean_square, CV_32F, 1.0 / static_cast<double>(pictures));
  cv::subtract(mean_square, green_mean.mul(green_mean), variance);
  cv::sqrt(cv::max(variance, 0.0), deviation);
  return deviation;
}

double median_of(std::vector<float>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

int level_of(float brightness) {
  return std::clamp(static_cast<int>(brightness) * kLevels / 256, 0, kLevels - 1);
}

std::array<double, kLevels> typical_deviations(const cv::Mat& mean, const cv::Mat& deviation) {
  std::array<std::vector<float>, kLevels> by_level;
  for (int y = 0; y < mean.rows; ++y)
    for (int x = 0; x < mean.cols; ++x)
      by_level[static_cast<std::size_t>(level_of(mean.at<float>(y, x)))].push_back(deviation.at<float>(y, x));
  std::array<double, kLevels> typical{};
  const auto fewest = static_cast<std::size_t>(kFewestShare * static_cast<double>(mean.total()));
  for (std::size_t i = 0; i < typical.size(); ++i)
    typical[i] = by_level[i].size() < fewest ? std::numeric_limits<double>::infinity() : median_of(by_level[i]);
  return typical;
}

// A level that only the one who moves has must not set its own measure: its neighbours' counts too, for the noise of
// levels next to each other differs by less than half.
std::array<double, kLevels> still_deviations(const cv::Mat& mean, const cv::Mat& deviation) {
  const auto typical = typical_deviations(mean, deviation);
  auto still = typical;
  for (std::size_t i = 0; i < still.size(); ++i) {
    if (i > 0) still[i] = std::min(still[i], 1.5 * typical[i - 1] + kStep);
    if (i + 1 < still.size()) still[i] = std::min(still[i], 1.5 * typical[i + 1] + kStep);
  }
  const double anywhere = *std::min_element(still.begin(), still.end());
  for (auto& level : still)
    if (!std::isfinite(level)) level = 2.0 * anywhere + kStep;  // far from anything that holds still
  return still;
}

double moving_share(const cv::Mat& mean, const cv::Mat& deviation) {
  const auto still = still_deviations(mean, deviation);
  std::size_t moving = 0;
  for (int y = 0; y < mean.rows; ++y)
    for (int x = 0; x < mean.cols; ++x) {
      const auto level = static_cast<std::size_t>(level_of(mean.at<float>(y, x)));
      if (deviation.at<float>(y, x) > kMovingAbove * still[level] + kStep) ++moving;
    }
  return static_cast<double>(moving) / static_cast<double>(mean.total());
}

}  // namespace

void EmptyStudioAverage::add(const cv::Mat& rgb) {
  if (pictures_ == 0) {
    sum_ = cv::Mat::zeros(rgb.size(), CV_16UC3);
    green_squares_ = cv::Mat::zeros(rgb.size(), CV_32FC1);
  }
  if (rgb.size() != sum_.size() || rgb.type() != CV_8UC3)
    throw InvalidInput("a picture of the empty studio is of another size than those before it");
  if (pictures_ >= kMostPictures) return;
  cv::add(sum_, rgb, sum_, cv::noArray(), CV_16UC3);
  cv::Mat green;
  cv::extractChannel(rgb, green, 1);
  green.convertTo(green, CV_32F);
  green_squares_ += green.mul(green);
  ++pictures_;
}

EmptyStudio EmptyStudioAverage::result() const {
  if (pictures_ < 2) throw InvalidInput("the empty studio needs two pictures at least");
  EmptyStudio studio{.picture = {}, .pictures = pictures_};
  const double scale = 1.0 / static_cast<double>(pictures_);
  sum_.convertTo(studio.picture, CV_8UC3, scale);
  cv::Mat mean;
  cv::extractChannel(sum_, mean, 1);
  mean.convertTo(mean, CV_32F, scale);
  const cv::Mat deviation = deviation_in_time(mean, green_squares_, pictures_);
  std::vector<float> all(deviation.begin<float>(), deviation.end<float>());
  studio.noise = median_of(all);
  studio.moving_share = moving_share(mean, deviation);
  return studio;
}

}  // namespace rotunda::capture
