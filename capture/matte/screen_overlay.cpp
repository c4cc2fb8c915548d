#include "capture/matte/screen_overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/matte/screen_light.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kGood = 0.5;        // stops from the middle: together one stop, what the key is built for
constexpr double kBad = 1.0;         // stops
constexpr double kLine = 1.0 / 3.0;  // stops between lines
constexpr double kDetail = 1 / 240.0,
                 kPlace = 1 / 40.0;  // of the width: sigmas that noise and that places are smoothed by

const cv::Vec3b kDark(45, 85, 235), kVeryDark(20, 25, 120), kBright(245, 150, 30), kVeryBright(220, 35, 35);
const cv::Vec3b kWeak(225, 40, 200);

cv::Vec3b striped(int x, int y) {
  return (x + y) % 8 < 4 ? cv::Vec3b(255, 255, 255) : cv::Vec3b(0, 0, 0);
}

// Between the dark and the bright end of the screen that its evenness is told by.
float middle_light(const cv::Mat& light, const cv::Mat& mask) {
  std::vector<float> values;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask.at<std::uint8_t>(y, x)) values.push_back(light.at<float>(y, x));
  if (values.empty()) return 1.0F;
  const auto percentile = [&](double share) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return std::max(1e-4F, *at);
  };
  return std::sqrt(percentile(0.05) * percentile(0.95));
}

// log2 of the light against the screen's middle, smoothed over the screen alone; CV_32FC1.
cv::Mat stops_of(const cv::Mat& light, const cv::Mat& mask, double sigma) {
  cv::Mat share, stops, masked = cv::Mat::zeros(light.size(), CV_32FC1);
  light.copyTo(masked, mask);
  mask.convertTo(share, CV_32F, 1.0 / 255.0);
  cv::GaussianBlur(masked, masked, {}, sigma);
  cv::GaussianBlur(share, share, {}, sigma);
  cv::log(cv::max(masked / cv::max(share, 1e-3), 1e-4) / middle_light(light, mask), stops);
  return stops / std::log(2.0);
}

int line_band(float stops) {
  return static_cast<int>(std::floor(stops / static_cast<float>(kLine) + 0.5F));
}

// Quiet where it is good.
cv::Vec3b colour_at(const cv::Mat& stops, int x, int y, const cv::Vec3b& own) {
  const float here = stops.at<float>(y, x);
  if (here < -kBad) return kVeryDark;
  if (here < -kGood) return kDark;
  if (here > kBad) return kVeryBright;
  if (here > kGood) return kBright;
  const bool on_line = line_band(here) != line_band(stops.at<float>(y, std::min(x + 1, stops.cols - 1))) ||
                       line_band(here) != line_band(stops.at<float>(std::min(y + 1, stops.rows - 1), x));
  const double share = on_line ? 0.85 : 0.55;
  return cv::Vec3b(cv::saturate_cast<std::uint8_t>(share * own[0]), cv::saturate_cast<std::uint8_t>(share * own[1]),
                   cv::saturate_cast<std::uint8_t>(share * own[2]));
}

double text_scale(int width) {
  return std::clamp(width / 1500.0, 0.36, 0.8);
}

void write_line(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
                const cv::Scalar& colour = {235, 235, 235}) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, colour, 1, cv::LINE_AA);
}

void mark(cv::Mat& picture, cv::Point at, double stops) {
  const double scale = 1.15 * text_scale(picture.cols);
  const int radius = std::max(6, picture.cols / 60);
  const std::string text = fmt::format("{:+.1f}", stops);
  int below = 0;
  const auto size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &below);
  const int x = at.x + radius + 4 + size.width < picture.cols ? at.x + radius + 4 : at.x - radius - 4 - size.width;
  const cv::Point where(std::max(2, x), std::clamp(at.y + size.height / 2, size.height + 2, picture.rows - 4));
  cv::circle(picture, at, radius, {0, 0, 0}, 5, cv::LINE_AA);
  cv::circle(picture, at, radius, {255, 255, 255}, 2, cv::LINE_AA);
  const cv::Rect behind(where.x - 3, where.y - size.height - 3, size.width + 6, size.height + below + 4);
  picture(behind & cv::Rect({}, picture.size())).setTo(cv::Scalar(0, 0, 0));
  write_line(picture, text, where, scale, {255, 255, 255});
}

// The brightest and the darkest place, each as wide as a hand's breadth of the picture, away from the mask's edges.
void mark_extremes(cv::Mat& picture, const cv::Mat& light, const cv::Mat& mask) {
  const cv::Mat places = stops_of(light, mask, kPlace * picture.cols);
  const int reach = std::max(1, picture.cols / 60);
  cv::Mat framed = mask.clone(), inner;
  cv::rectangle(framed, {0, 0, mask.cols, mask.rows}, 0, reach);
  cv::erode(framed, inner, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8UC1));
  if (cv::countNonZero(inner) == 0) return;
  double least = 0.0, most = 0.0;
  cv::Point darkest, brightest;
  cv::minMaxLoc(places, &least, &most, &darkest, &brightest, inner);
  mark(picture, darkest, least);
  mark(picture, brightest, most);
}

struct LegendEntry {
  std::vector<cv::Vec3b> patches;
  bool is_striped;
  const char* text;
};

void draw_legend(cv::Mat& strip, int y, double scale, Backdrop backdrop) {
  const cv::Vec3b good = backdrop == Backdrop::blue ? cv::Vec3b(28, 52, 112) : cv::Vec3b(36, 104, 50);
  const std::array<LegendEntry, 6> entries{{{{good}, false, "good"},
                                            {{kDark, kVeryDark}, false, "dark: 1/2, 1 stop"},
                                            {{kBright, kVeryBright}, false, "bright: 1/2, 1 stop"},
                                            {{kWeak}, false, "weak colour"},
                                            {{{0, 0, 0}}, true, "over-exposed"},
                                            {{{90, 90, 90}}, false, "no screen"}}};
  const int size = static_cast<int>(std::lround(30 * scale));
  int x = 8;
  for (const auto& entry : entries) {
    for (const auto& patch : entry.patches) {
      for (int j = 0; j < size; ++j)
        for (int i = 0; i < size && x + i < strip.cols; ++i)
          strip.at<cv::Vec3b>(y + j, x + i) = entry.is_striped ? striped(i, j) : patch;
      x += size;
    }
    write_line(strip, entry.text, {x + 5, y + size - 2}, 0.85 * scale);
    int below = 0;
    x += cv::getTextSize(entry.text, cv::FONT_HERSHEY_SIMPLEX, 0.85 * scale, 1, &below).width + 16;
  }
}

cv::Mat text_strip(int width, const ScreenReading& r, const std::string& title, Backdrop backdrop) {
  const double scale = text_scale(width);
  const int row = static_cast<int>(std::lround(40 * scale));
  const auto lines = static_cast<int>(r.advice.size());
  cv::Mat strip(row * (4 + lines) + row / 2, width, CV_8UC3, cv::Scalar(24, 26, 30));
  if (lines == 0) write_line(strip, title + ": good", {8, row}, 1.2 * scale, {120, 220, 140});
  if (lines > 0) write_line(strip, title + ":", {8, row}, 1.2 * scale, {255, 190, 90});
  for (int i = 0; i < lines; ++i)
    write_line(strip, r.advice[static_cast<std::size_t>(i)], {8, (2 + i) * row}, scale, {255, 190, 90});
  const int after = 1 + lines;
  write_line(strip,
             fmt::format("{:.0f} % screen, {:.2f}:1, saturation {:.2f} (least {:.2f}), {:.1f} % clipped", 100 * r.share,
                         r.unevenness, r.saturation, r.least_saturation, 100 * r.clipped),
             {8, (after + 1) * row}, scale);
  write_line(strip,
             fmt::format("noise {:.1f} levels, {:.0f} deviations of headroom{}", r.noise, r.headroom,
                         r.spill ? fmt::format(", spill {:.0f} levels", *r.spill) : ""),
             {8, (after + 2) * row}, scale);
  draw_legend(strip, strip.rows - row, scale, backdrop);
  return strip;
}

}  // namespace

cv::Mat screen_overlay(const ScreenPicture& picture, Backdrop backdrop, const ScreenReading& reading) {
  const cv::Mat& rgb = picture.rgb;
  if (rgb.empty() || rgb.type() != CV_8UC3)
    throw InvalidInput("the screen's overlay wants a picture of 8-bit red, green, blue");
  if (!picture.alpha.empty() && (picture.alpha.type() != CV_8UC1 || picture.alpha.size() != rgb.size()))
    throw InvalidInput("the matte must be of the picture's size");
  const int own = own_channel(backdrop);
  const cv::Mat mask = screen_mask(rgb, backdrop, picture.alpha), light = own_light(rgb, own);
  const cv::Mat stops = stops_of(light, mask, kDetail * rgb.cols);
  cv::Mat grey, overlay, result;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  cv::cvtColor(grey * 0.45, overlay, cv::COLOR_GRAY2RGB);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      if (!mask.at<std::uint8_t>(y, x)) continue;
      const auto& pixel = rgb.at<cv::Vec3b>(y, x);
      auto& out = overlay.at<cv::Vec3b>(y, x);
      out = colour_at(stops, x, y, pixel);
      if (saturation_at(pixel, own) < kWeakSaturation) out = kWeak;
      if (pixel[own] >= kScreenClipped) out = striped(x, y);
    }
  if (cv::countNonZero(mask) > 0) mark_extremes(overlay, light, mask);
  cv::vconcat(overlay, text_strip(rgb.cols, reading, picture.title, backdrop), result);
  return result;
}

}  // namespace rotunda::capture
