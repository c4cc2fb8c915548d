#include "capture/matte/screen_meter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/matte/screen_light.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kLeastShare = 0.02;  // of the picture; less is no screen
constexpr double kUneven = 2.0;       // one stop: as far as the key is built for
constexpr double kMostClipped = 0.01;
constexpr double kLeastHeadroom = 4.0;   // standard deviations: 1 pixel in 30 000 by chance
constexpr double kMostSpill = 12.0;      // grey levels
constexpr double kPerformerAt = 0.25;    // the key's log ratio (chroma_key.h) at which a lit pixel is performer
constexpr double kKeyBlur = 0.5;         // sigma of the key's own smoothing, pixels: it halves white noise
constexpr double kNoiseAfterBlur = 0.6;  // standard deviation left by it

double percentile(std::vector<float>& values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// A value a screen pixel.
template <class Value>
std::vector<float> over_screen(const cv::Mat& mask, Value value) {
  std::vector<float> values;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask.at<std::uint8_t>(y, x)) values.push_back(static_cast<float>(value(y, x)));
  return values;
}

// Standard deviation of noise from median absolute values: 0.6745 of it.
double from_median(std::vector<float> magnitudes) {
  return percentile(magnitudes, 0.5) / 0.6745;
}

// Over time where there are two pictures; else from Immerkaer's Laplacian (1996), in which flat and sloping paint is 0.
double noise_of(std::span<const cv::Mat> pictures, const cv::Mat& mask, int own) {
  cv::Mat first, other;
  cv::extractChannel(pictures[0], first, own);
  if (pictures.size() > 1) {
    cv::extractChannel(pictures[1], other, own);
    cv::Mat apart;
    cv::absdiff(first, other, apart);
    return from_median(over_screen(mask,
                                   [&](int y, int x) {
                                     // A whole level stands for what was rounded to it: spread evenly, the median is
                                     // not a step.
                                     const double level = apart.at<std::uint8_t>(y, x);
                                     return level == 0 ? 0.25 : level;
                                   })) /
           std::sqrt(2.0);
  }
  const cv::Mat kernel = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat detail;
  cv::filter2D(first, detail, CV_32F, kernel);
  return from_median(over_screen(mask, [&](int y, int x) { return std::abs(detail.at<float>(y, x)); })) / 6.0;
}

// Of the key's d = ln(R/Rp) - ln(B/Bp): its noise at a pixel follows from that of the two channels it compares.
double headroom_of(const cv::Mat& rgb, const cv::Mat& mask, int own, double noise) {
  auto margins = over_screen(mask, [&](int y, int x) {
    const auto& p = rgb.at<cv::Vec3b>(y, x);
    const double others = std::max(p[(own + 1) % 3], p[(own + 2) % 3]) + kLogOffset, mine = p[own] + kLogOffset;
    const double deviation = kNoiseAfterBlur * std::max(noise, 0.3) * std::hypot(1.0 / others, 1.0 / mine);
    return kPerformerAt / deviation;
  });
  return percentile(margins, 0.05);
}

// Mean lead of the backdrop's channel where `where` is set, grey levels.
double mean_lead(const cv::Mat& rgb, const cv::Mat& where, int own) {
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x)
      if (where.at<std::uint8_t>(y, x)) {
        const auto& p = rgb.at<cv::Vec3b>(y, x);
        sum += p[own] - std::max(p[(own + 1) % 3], p[(own + 2) % 3]);
        ++count;
      }
  return count > 0 ? sum / count : 0.0;
}

// The rim from 2 to 6 px inside the outline (what lies further out mixes backdrop in) against cloth 8 to 14 px inside.
std::optional<double> spill_of(const cv::Mat& rgb, const cv::Mat& alpha, int own) {
  if (alpha.empty() || cv::countNonZero(alpha >= 128) == 0) return std::nullopt;
  cv::Mat depth;
  cv::distanceTransform(alpha >= 128, depth, cv::DIST_L2, 3, CV_32F);
  const cv::Mat rim = (depth > 2) & (depth <= 6), cloth = (depth > 8) & (depth <= 14);
  if (cv::countNonZero(rim) == 0 || cv::countNonZero(cloth) == 0) return std::nullopt;
  return mean_lead(rgb, rim, own) - mean_lead(rgb, cloth, own);
}

std::string place_name(int column, int row) {
  constexpr std::array kRows = {"upper", "middle", "lower"};
  constexpr std::array kColumns = {"left", "middle", "right"};
  if (column == 1 && row == 1) return "middle";
  if (row == 1) return kColumns[static_cast<std::size_t>(column)];
  if (column == 1) return std::string(kRows[static_cast<std::size_t>(row)]) + " middle";
  return std::string(kRows[static_cast<std::size_t>(row)]) + " " + kColumns[static_cast<std::size_t>(column)];
}

// The brightest and the darkest ninth of the picture, where the screen fills some of it.
void name_extremes(const cv::Mat& light, const cv::Mat& mask, ScreenReading& reading) {
  double brightest = -1.0, darkest = 2.0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const cv::Rect part(column * mask.cols / 3, row * mask.rows / 3, mask.cols / 3, mask.rows / 3);
      if (cv::countNonZero(mask(part)) < part.area() / 20) continue;
      const double mean = cv::mean(light(part), mask(part))[0];
      if (mean > brightest) reading.brightest = place_name(column, row);
      if (mean < darkest) reading.darkest = place_name(column, row);
      brightest = std::max(brightest, mean);
      darkest = std::min(darkest, mean);
    }
  if (brightest < 1.2 * darkest) reading.brightest.clear(), reading.darkest.clear();
}

void advise(ScreenReading& r, const char* colour) {
  const auto say = [&](std::string sentence) { r.advice.push_back(std::move(sentence)); };
  if (r.share < kLeastShare)
    return say(fmt::format("sees no {} screen ({:.1f} % of the picture): another backdrop?", colour, 100 * r.share));
  if (r.unevenness > kUneven)
    say(r.brightest.empty() ? fmt::format("the light falls off {:.1f}:1 in small parts: move lamps back", r.unevenness)
                            : fmt::format("{:.1f}:1 uneven: brightest {}, darkest {}: move light from there to there",
                                          r.unevenness, r.brightest, r.darkest));
  if (r.clipped > kMostClipped)
    say(fmt::format("{:.1f} % of the screen is over-exposed: less light on it, or a shorter exposure",
                    100 * r.clipped));
  if (r.least_saturation < kWeakSaturation)
    say(fmt::format(
        "the {} is weak in parts (saturation {:.2f}): white light falls on the screen, flag the performer's lamps",
        colour, r.least_saturation));
  if (r.headroom < kLeastHeadroom)
    say(fmt::format(
        "too noisy for its brightness ({:.1f} levels, {:.1f} deviations to the key's limit): more light on the screen, "
        "less gain",
        r.noise, r.headroom));
  if (r.spill && *r.spill > kMostSpill)
    say(fmt::format("{:.0f} levels of {} spill on the performer: further from the screen, or less light on it",
                    *r.spill, colour));
}

void check(std::span<const cv::Mat> pictures, const cv::Mat& alpha) {
  if (pictures.empty()) throw InvalidInput("a screen is measured on a picture at least");
  for (const auto& picture : pictures)
    if (picture.type() != CV_8UC3 || picture.size() != pictures[0].size() || picture.empty())
      throw InvalidInput("a camera's pictures of the screen must be RGB and of one size");
  if (!alpha.empty() && (alpha.type() != CV_8UC1 || alpha.size() != pictures[0].size()))
    throw InvalidInput("the matte must be of the picture's size");
}

}  // namespace

ScreenReading measure_screen(std::span<const cv::Mat> pictures, Backdrop backdrop, const cv::Mat& alpha) {
  check(pictures, alpha);
  const cv::Mat& rgb = pictures[0];
  const int own = own_channel(backdrop);
  const cv::Mat mask = screen_mask(rgb, backdrop, alpha);
  const cv::Mat light = own_light(rgb, own);
  ScreenReading reading;
  reading.share = static_cast<double>(cv::countNonZero(mask)) / static_cast<double>(mask.total());
  const char* colour = backdrop == Backdrop::blue ? "blue" : "green";
  if (reading.share >= kLeastShare) {
    auto levels = over_screen(mask, [&](int y, int x) { return light.at<float>(y, x); });
    const double dark = percentile(levels, 0.05);
    reading.unevenness = percentile(levels, 0.95) / std::max(1e-4, dark);
    auto saturations = over_screen(mask, [&](int y, int x) { return saturation_at(rgb.at<cv::Vec3b>(y, x), own); });
    reading.saturation = percentile(saturations, 0.5);
    reading.least_saturation = percentile(saturations, 0.05);
    const auto at_end = over_screen(mask, [&](int y, int x) { return rgb.at<cv::Vec3b>(y, x)[own] >= kScreenClipped; });
    reading.clipped =
        static_cast<double>(std::count(at_end.begin(), at_end.end(), 1.0F)) / static_cast<double>(at_end.size());
    reading.noise = noise_of(pictures, mask, own);
    reading.headroom = headroom_of(rgb, mask, own, reading.noise);
    reading.spill = spill_of(rgb, alpha, own);
    name_extremes(light, mask, reading);
  }
  advise(reading, colour);
  return reading;
}

}  // namespace rotunda::capture
