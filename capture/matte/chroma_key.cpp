#include "capture/matte/chroma_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/matte/cloth_in_doubt.h"
#include "capture/matte/edge_matte.h"
#include "capture/matte/key_limit.h"
#include "capture/matte/mask_pieces.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr double kBlur = 0.7;  // sigma, pixels: takes the demosaicing's chroma noise away before ratios are formed
// What share of a picture must show the backdrop's colour for the colour to tell anything.
constexpr double kLeastBackdrop = 0.05;
constexpr float kDifferenceStep = 0.16F;  // of ln(channel): 17 % off the plate's colour at its best brightness
constexpr float kFirmLead = 0.3F;         // beyond the limit: a pixel half performer leads it by less
constexpr float kBareLead = -0.1F;        // the plate's own colour stands at -0.25
constexpr float kNoLead = -100.0F;        // off the screen and off the stage
constexpr int kBareGap = 3;               // pixels of it that make a gap
constexpr int kSmallestPiece = 4000;      // a picture's area over this is the smallest piece of performer kept
constexpr int kSmallestHole = 20000;
constexpr double kHalf = 127.0;    // of alpha
constexpr int kHeldDepth = 3;      // pixels inside the outline: there a mixture with the backdrop is none of its edge
constexpr int kOverexposed = 250;  // grey levels: what the sensor or its curve cannot tell from white
constexpr float kUnlit = 28.0F;    // grey levels, mean of a whole row or column: black level and ringing, no light
constexpr int kSpoiltLines = 4;    // pixels

cv::Mat blurred(const cv::Mat& rgb) {
  cv::Mat result;
  cv::GaussianBlur(rgb, result, {5, 5}, kBlur);
  return result;
}

KeyedPixels by_chroma(const cv::Mat& log_rgb, const cv::Mat& log_plate, const KeyChannels& channels) {
  const float least = std::log(kDarkest + kLogOffset);
  KeyedPixels inside;
  for (auto* mask : {&inside.all, &inside.firm, &inside.unlit, &inside.bare}) mask->create(log_rgb.size(), CV_8UC1);
  for (auto* values : {&inside.lead, &inside.brightness}) values->create(log_rgb.size(), CV_32FC1);
  for (int y = 0; y < log_rgb.rows; ++y) {
    const auto* pixel = log_rgb.ptr<cv::Vec3f>(y);
    const auto* plate = log_plate.ptr<cv::Vec3f>(y);
    auto *all = inside.all.ptr<std::uint8_t>(y), *firm = inside.firm.ptr<std::uint8_t>(y);
    auto *unlit = inside.unlit.ptr<std::uint8_t>(y), *bare = inside.bare.ptr<std::uint8_t>(y);
    auto *leads = inside.lead.ptr<float>(y), *brightness = inside.brightness.ptr<float>(y);
    for (int x = 0; x < log_rgb.cols; ++x) {
      const cv::Vec3f gain = pixel[x] - plate[x];
      const float lead = key_lead(gain, channels);
      const bool lit = pixel[x][channels.far] > least;
      all[x] = lit && lead > 0.0F ? 255 : 0;
      firm[x] = lit && lead > kFirmLead ? 255 : 0;
      unlit[x] = lit ? 0 : 255;
      bare[x] = lit && lead < kBareLead ? 255 : 0;
      brightness[x] = gain[channels.own];
      leads[x] = lead;
    }
  }
  return inside;
}

// Off the plate's colour by more than a change of light explains, or lighter or darker than any shadow.
bool is_different(const cv::Vec3f& gain) {
  const float light = std::clamp((gain[0] + gain[1] + gain[2]) / 3.0F, -0.7F, 0.1F);
  return std::max({std::abs(gain[0] - light), std::abs(gain[1] - light), std::abs(gain[2] - light)}) > kDifferenceStep;
}

// Where `screen` (CV_8UC1) is 0 only the difference can tell.
void tell_by_difference(const cv::Mat& log_rgb, const cv::Mat& log_plate, const cv::Mat& screen, KeyedPixels& inside) {
  for (int y = 0; y < log_rgb.rows; ++y)
    for (int x = 0; x < log_rgb.cols; ++x) {
      if (screen.at<std::uint8_t>(y, x) != 0) continue;
      const cv::Vec3f gain = log_rgb.at<cv::Vec3f>(y, x) - log_plate.at<cv::Vec3f>(y, x);
      const std::uint8_t value = is_different(gain) ? 255 : 0;
      inside.all.at<std::uint8_t>(y, x) = inside.firm.at<std::uint8_t>(y, x) = value;
      inside.unlit.at<std::uint8_t>(y, x) = inside.bare.at<std::uint8_t>(y, x) = 0;
      inside.lead.at<float>(y, x) = kNoLead;
    }
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
// bars' edges, which scanning and sharpening spoil, nor what is over-exposed in all colours for the most part: a lamp.
void drop_stray_pieces(cv::Mat& inside, const cv::Mat& rgb, const cv::Rect& lit) {
  cv::Mat kept = cv::Mat::zeros(inside.size(), CV_8UC1);
  inside(lit).copyTo(kept(lit));
  const int smallest = std::max(4, static_cast<int>(inside.total()) / kSmallestPiece);
  cv::Mat glaring;
  cv::inRange(rgb(lit), cv::Scalar::all(kOverexposed), cv::Scalar::all(255), glaring);
  turn_pieces(kept(lit), 255, glaring, [&](const int* piece, int glares) {
    const int x = piece[cv::CC_STAT_LEFT], width = piece[cv::CC_STAT_WIDTH];
    const int y = piece[cv::CC_STAT_TOP], height = piece[cv::CC_STAT_HEIGHT];
    const bool along_side = width <= kSpoiltLines && (x == 0 || x + width == lit.width);
    const bool along_end = height <= kSpoiltLines && (y == 0 || y + height == lit.height);
    return along_side || along_end || piece[cv::CC_STAT_AREA] < smallest || 2 * glares > piece[cv::CC_STAT_AREA];
  });
  inside = kept;
}

void keep_to_stage(const cv::Mat& stage, KeyedPixels& inside) {
  inside.all &= stage;
  inside.lead.setTo(kNoLead, ~stage);
}

// Where `held` is set everything but the plain backdrop is performer.
void hold(const cv::Mat& held, KeyedPixels& inside) {
  const cv::Mat kept = held & (inside.lead > kBareLead) & ~inside.unlit;
  inside.all |= kept;
  inside.firm |= kept;
}

// Small ones that do not plainly show the backdrop, as gaps between limbs do; and those too dark to tell that the
// performer surrounds: folds of the clothes, for the backdrop gets light wherever the camera sees it past somebody.
void fill_holes(KeyedPixels& inside) {
  const int smallest = std::max(4, static_cast<int>(inside.all.total()) / kSmallestHole);
  const cv::Mat before = inside.all.clone();
  turn_pieces(inside.all, 0, inside.bare,
              [&](const int* piece, int bare) { return piece[cv::CC_STAT_AREA] < smallest && bare < kBareGap; });
  turn_pieces(inside.all, 0, inside.unlit, [&](const int* piece, int unlit) {
    const int x = piece[cv::CC_STAT_LEFT], width = piece[cv::CC_STAT_WIDTH];
    const int y = piece[cv::CC_STAT_TOP], height = piece[cv::CC_STAT_HEIGHT];
    const bool is_surrounded = x > 0 && y > 0 && x + width < before.cols && y + height < before.rows;
    return is_surrounded && 2 * unlit > piece[cv::CC_STAT_AREA];
  });
  inside.firm |= inside.unlit & inside.all & ~before;
}

// Nothing where no screen's colour leads: then only a background's difference can tell.
std::optional<Backdrop> backdrop_for(const cv::Mat& rgb, const ChromaKeyOptions& options, const cv::Mat& background) {
  if (options.backdrop) return options.backdrop;
  return backdrop_of(background.empty() ? rgb : background);
}

bool use_difference(const cv::Mat& rgb, KeyMethod method, Backdrop backdrop, const cv::Mat& background) {
  if (method != KeyMethod::automatic) return method == KeyMethod::difference;
  return !background.empty() && backdrop_share(background, backdrop) < kLeastBackdrop &&
         backdrop_share(rgb, backdrop) < kLeastBackdrop;
}

void check(const cv::Mat& rgb, const ChromaKeyOptions& options, const cv::Mat& background) {
  if (rgb.type() != CV_8UC3) throw InvalidInput("the key wants pictures of 8-bit red, green, blue");
  if (!background.empty() && (background.size() != rgb.size() || background.type() != CV_8UC3))
    throw InvalidInput(
        fmt::format("the background is {} x {} pixels, the picture {} x {}; record the empty studio with "
                    "the same camera settings",
                    background.cols, background.rows, rgb.cols, rgb.rows));
  for (const auto* mask : {&options.stage, &options.held})
    if (!mask->empty() && (mask->size() != rgb.size() || mask->type() != CV_8UC1))
      throw InvalidInput("the stage's mask, or that of the performer held, is not of the picture's size");
  if (options.method == KeyMethod::difference && background.empty())
    throw InvalidInput("keying by difference needs a picture of the empty studio (--background)");
}

}  // namespace

Matte chroma_key(const cv::Mat& rgb, const ChromaKeyOptions& options, const cv::Mat& background) {
  check(rgb, options, background);
  const auto backdrop = backdrop_for(rgb, options, background).value_or(Backdrop::blue);
  const cv::Mat log_rgb = log_picture(blurred(rgb));
  const bool difference = use_difference(rgb, options.method, backdrop, background);
  const cv::Mat plate = background.empty() ? cv::Mat() : blurred(background);
  cv::Mat log_plate = plate.empty() ? fit_plate(rgb, backdrop) : log_picture(plate);
  if (log_plate.empty()) return {cv::Mat::zeros(rgb.size(), CV_8UC1)};
  if (!plate.empty() && !difference) log_plate += light_change(log_rgb, log_plate, backdrop);
  KeyedPixels inside = by_chroma(log_rgb, log_plate, key_channels(log_plate, backdrop));
  if (!plate.empty()) {
    const cv::Mat screen = difference ? cv::Mat::zeros(rgb.size(), CV_8UC1) : backdrop_mask(plate, backdrop);
    tell_by_difference(log_rgb, log_plate, screen, inside);
  }
  if (!options.stage.empty()) keep_to_stage(options.stage, inside);
  drop_stray_pieces(inside.all, rgb, lit_area(rgb));
  fill_open_folds(inside);
  add_sharp_edged_cloth(inside);
  if (!options.held.empty()) hold(options.held, inside);
  fill_holes(inside);
  firm_wide_cloth(inside);
  return edge_matte(rgb, background.empty() ? picture_of_log(log_plate) : background, inside.all, inside.firm);
}

cv::Mat held_between(const Matte& before, const Matte& after) {
  if (before.alpha.empty() || after.alpha.empty()) return {};
  if (before.alpha.size() != after.alpha.size()) throw InvalidInput("mattes of one camera differ in size");
  cv::Mat held;
  cv::erode((before.alpha > kHalf) & (after.alpha > kHalf), held,
            cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kHeldDepth + 1, 2 * kHeldDepth + 1}));
  return held;
}

}  // namespace rotunda::capture
