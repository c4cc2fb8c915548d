#include "capture/matte/chroma_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/matte/edge_matte.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kBlur = 0.7;  // sigma, pixels: takes the demosaicing's chroma noise away before ratios are formed
// What share of a picture must show the backdrop's colour for the colour to tell anything.
constexpr double kLeastBackdrop = 0.05;
constexpr float kDifferenceStep = 0.16F;  // of ln(channel): 17 % off the plate's colour at its best brightness
constexpr int kSmallestPiece = 4000;      // a picture's area over this is the smallest piece of performer kept
constexpr int kSmallestHole = 20000;
constexpr float kUnlit = 28.0F;  // grey levels, mean of a whole row or column: black level and ringing, no light
constexpr int kSpoiltLines = 4;  // pixels

// The limit that d = ln(R/Rp) - ln(B/Bp) must pass to be performer, by brightness l = ln(B/Bp): shadow stays well below
// zero where dark cloth and hair come near it.
float limit_at(float l) {
  constexpr std::array<std::pair<float, float>, 5> kKnots{
      {{-3.0F, -0.9F}, {-1.5F, -0.5F}, {-0.9F, -0.15F}, {-0.5F, 0.25F}, {0.0F, 0.25F}}};
  if (l <= kKnots.front().first) return kKnots.front().second;
  for (std::size_t i = 1; i < kKnots.size(); ++i)
    if (l < kKnots[i].first) {
      const float share = (l - kKnots[i - 1].first) / (kKnots[i].first - kKnots[i - 1].first);
      return kKnots[i - 1].second + share * (kKnots[i].second - kKnots[i - 1].second);
    }
  return kKnots.back().second;
}

cv::Mat blurred(const cv::Mat& rgb) {
  cv::Mat result;
  cv::GaussianBlur(rgb, result, {5, 5}, kBlur);
  return result;
}

cv::Mat by_chroma(const cv::Mat& log_rgb, const cv::Mat& log_plate, Backdrop backdrop) {
  const int own = backdrop == Backdrop::blue ? 2 : 1;
  const int other = backdrop == Backdrop::blue ? 1 : 2;
  cv::Mat inside(log_rgb.size(), CV_8UC1);
  for (int y = 0; y < inside.rows; ++y) {
    const auto* pixel = log_rgb.ptr<cv::Vec3f>(y);
    const auto* plate = log_plate.ptr<cv::Vec3f>(y);
    auto* out = inside.ptr<std::uint8_t>(y);
    for (int x = 0; x < inside.cols; ++x) {
      const cv::Vec3f gain = pixel[x] - plate[x];
      const float gained = std::max(gain[0], gain[other]) - gain[own];
      out[x] = gained > limit_at(gain[own]) ? 255 : 0;
    }
  }
  return inside;
}

// Off the plate's colour by more than a change of light explains, or lighter or darker than any shadow.
cv::Mat by_difference(const cv::Mat& log_rgb, const cv::Mat& log_plate) {
  cv::Mat inside(log_rgb.size(), CV_8UC1);
  for (int y = 0; y < inside.rows; ++y)
    for (int x = 0; x < inside.cols; ++x) {
      const cv::Vec3f gain = log_rgb.at<cv::Vec3f>(y, x) - log_plate.at<cv::Vec3f>(y, x);
      const float light = std::clamp((gain[0] + gain[1] + gain[2]) / 3.0F, -0.7F, 0.1F);
      float most = 0.0F;
      for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(gain[c] - light));
      inside.at<std::uint8_t>(y, x) = most > kDifferenceStep ? 255 : 0;
    }
  return inside;
}

// Turns the pieces of `value` (0 or 255) over that `goes` says of, by their statistics (cv::ConnectedComponentsTypes).
template <class Goes>
void turn_pieces(cv::Mat mask, std::uint8_t value, const Goes& goes) {
  cv::Mat labels, statistics, centres;
  const int count = cv::connectedComponentsWithStats(mask == value, labels, statistics, centres, value ? 8 : 4, CV_32S);
  std::vector<std::uint8_t> after(static_cast<std::size_t>(count), value);
  after[0] = static_cast<std::uint8_t>(255 - value);
  for (int piece = 1; piece < count; ++piece)
    if (goes(statistics.ptr<int>(piece))) after[static_cast<std::size_t>(piece)] = after[0];
  for (int y = 0; y < mask.rows; ++y)
    std::transform(labels.ptr<int>(y), labels.ptr<int>(y) + mask.cols, mask.ptr<std::uint8_t>(y),
                   [&](int label) { return after[static_cast<std::size_t>(label)]; });
}

// The part of the picture that got light: digitised video has black bars along its sides, wholly dark rows and columns.
cv::Rect lit_area(const cv::Mat& rgb) {
  cv::Mat column_means, row_means;
  cv::reduce(rgb, column_means, 0, cv::REDUCE_AVG, CV_32F);
  cv::reduce(rgb, row_means, 1, cv::REDUCE_AVG, CV_32F);
  const auto is_dark = [](const cv::Vec3f& mean) { return std::max({mean[0], mean[1], mean[2]}) < kUnlit; };
  int left = 0, right = rgb.cols, top = 0, bottom = rgb.rows;
  while (left < right && is_dark(column_means.at<cv::Vec3f>(0, left))) ++left;
  while (right > left && is_dark(column_means.at<cv::Vec3f>(0, right - 1))) --right;
  while (top < bottom && is_dark(row_means.at<cv::Vec3f>(top, 0))) ++top;
  while (bottom > top && is_dark(row_means.at<cv::Vec3f>(bottom - 1, 0))) --bottom;
  if (left == right || top == bottom) return {{}, rgb.size()};  // dark all over: nothing to tell bars by
  return {left, top, right - left, bottom - top};
}

// Nothing in the bars is performer, nor any small piece, nor what keeps to the lines next to the picture's and the
// bars' edges, which scanning and sharpening spoil.
void drop_stray_pieces(cv::Mat& inside, const cv::Rect& lit) {
  cv::Mat kept = cv::Mat::zeros(inside.size(), CV_8UC1);
  inside(lit).copyTo(kept(lit));
  const int smallest = std::max(4, static_cast<int>(inside.total()) / kSmallestPiece);
  turn_pieces(kept(lit), 255, [&](const int* piece) {
    const int x = piece[cv::CC_STAT_LEFT], width = piece[cv::CC_STAT_WIDTH];
    const int y = piece[cv::CC_STAT_TOP], height = piece[cv::CC_STAT_HEIGHT];
    const bool along_side = width <= kSpoiltLines && (x == 0 || x + width == lit.width);
    const bool along_end = height <= kSpoiltLines && (y == 0 || y + height == lit.height);
    return along_side || along_end || piece[cv::CC_STAT_AREA] < smallest;
  });
  inside = kept;
}

void fill_small_holes(cv::Mat& inside) {
  const int smallest = std::max(4, static_cast<int>(inside.total()) / kSmallestHole);
  turn_pieces(inside, 0, [&](const int* piece) { return piece[cv::CC_STAT_AREA] < smallest; });
}

cv::Mat picture_of(const cv::Mat& log_plate) {
  cv::Mat plate, bytes;
  cv::exp(log_plate, plate);
  plate.convertTo(bytes, CV_8U, 1.0, -kLogOffset);
  return bytes;
}

bool use_difference(const cv::Mat& rgb, const ChromaKeyOptions& options, const cv::Mat& background) {
  if (options.method != KeyMethod::automatic) return options.method == KeyMethod::difference;
  return !background.empty() && backdrop_share(background, options.backdrop) < kLeastBackdrop &&
         backdrop_share(rgb, options.backdrop) < kLeastBackdrop;
}

void check(const cv::Mat& rgb, const ChromaKeyOptions& options, const cv::Mat& background) {
  if (rgb.type() != CV_8UC3) throw InvalidInput("the key wants pictures of 8-bit red, green, blue");
  if (!background.empty() && (background.size() != rgb.size() || background.type() != CV_8UC3))
    throw InvalidInput(
        fmt::format("the background is {} x {} pixels, the picture {} x {}; record the empty studio with "
                    "the same camera settings",
                    background.cols, background.rows, rgb.cols, rgb.rows));
  if (options.method == KeyMethod::difference && background.empty())
    throw InvalidInput("keying by difference needs a picture of the empty studio (--background)");
}

}  // namespace

Matte chroma_key(const cv::Mat& rgb, const ChromaKeyOptions& options, const cv::Mat& background) {
  check(rgb, options, background);
  const cv::Mat log_rgb = log_picture(blurred(rgb));
  const bool difference = use_difference(rgb, options, background);
  const cv::Mat log_plate = background.empty() ? fit_plate(rgb, options.backdrop) : log_picture(blurred(background));
  if (log_plate.empty()) return {cv::Mat::zeros(rgb.size(), CV_8UC1)};
  cv::Mat inside = difference ? by_difference(log_rgb, log_plate) : by_chroma(log_rgb, log_plate, options.backdrop);
  drop_stray_pieces(inside, lit_area(rgb));
  fill_small_holes(inside);
  return edge_matte(rgb, background.empty() ? picture_of(log_plate) : background, inside);
}

}  // namespace rotunda::capture
