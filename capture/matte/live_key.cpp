#include "capture/matte/live_key.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/matte/half_edge.h"
#include "capture/matte/key_limit.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

constexpr int kOffset = static_cast<int>(kLogOffset) * kHalfScale;
constexpr int kUnit = 256;            // a ratio of 1
constexpr int kLeastPlate = kUnit;    // of plate and offset, so that kUnit * 2^16 over it is 16 bits
constexpr int kSmallestPiece = 4000;  // a picture's area over this is the smallest piece of performer kept
constexpr int kSmallestHole = 20000;
constexpr int kLightStride = 8;  // half-size pixels
constexpr std::size_t kFewestLightPixels = 32;
constexpr int kOverexposed = 250;  // grey levels: what the sensor or its curve cannot tell from white
constexpr int kPool = 2;           // half-size pixels a side that pieces are told by

// The limit as lines in the ratios themselves: between knots the exact limit bends by less than 0.02.
struct LimitLine {
  std::uint16_t slope = 0, less = 0;  // slope in 1/8192, to be taken off in 1/kUnit
};
struct Limit {
  std::array<LimitLine, kKeyKnots.size()> rising;  // the greatest of these,
  std::uint16_t top = 0;                           // but not above this slope
};

Limit limit_lines() {
  Limit limit;
  double x0 = 0.0, y0 = 0.0;
  for (std::size_t i = 0; i < kKeyKnots.size(); ++i) {
    const double x = std::exp(kKeyKnots[i].brightness), y = x * std::exp(kKeyKnots[i].lead);
    const double slope = (y - y0) / (x - x0);
    limit.rising[i] = {static_cast<std::uint16_t>(8192.0 * slope + 0.5),
                       static_cast<std::uint16_t>(kUnit * std::max(0.0, slope * x - y) + 0.5)};
    x0 = x, y0 = y;
  }
  limit.top = static_cast<std::uint16_t>(8192.0 * std::exp(kKeyKnots.back().lead) + 0.5);
  return limit;
}

// Eight pixels: the high half of 16 x 16 bits is a ratio in 1/kUnit.
cv::v_uint16x8 ratio(const std::uint16_t* value, const std::uint16_t* scale) {
  return cv::v_mul_hi(cv::v_load(value) + cv::v_setall_u16(kOffset), cv::v_load(scale));
}

cv::v_uint16x8 limit_of(const cv::v_uint16x8& brightness, const Limit& limit) {
  const auto eightfold = cv::v_shl<3>(brightness);
  auto greatest = cv::v_setzero_u16();
  for (const auto& line : limit.rising)
    greatest = cv::v_max(greatest, cv::v_mul_hi(eightfold, cv::v_setall_u16(line.slope)) - cv::v_setall_u16(line.less));
  return cv::v_min(greatest, cv::v_mul_hi(eightfold, cv::v_setall_u16(limit.top)));
}

// Ratios to what they would be in the plate's light; `light` in 1/kLightUnit.
constexpr int kLightUnit = 1 << 14;  // ratios stay below 16, so that a quarter of 16 bits is left
cv::v_uint16x8 in_light(const cv::v_uint16x8& ratio, std::uint16_t light) {
  return cv::v_mul_hi(cv::v_shl<2>(ratio), cv::v_setall_u16(light));
}

cv::Mat scale_of(const cv::Mat& plate) {
  cv::Mat scale(plate.size(), CV_16UC1);
  for (int y = 0; y < plate.rows; ++y)
    std::transform(
        plate.ptr<std::uint16_t>(y), plate.ptr<std::uint16_t>(y) + plate.cols, scale.ptr<std::uint16_t>(y),
        [](std::uint16_t value) {
          return static_cast<std::uint16_t>(std::min(65535, kUnit * 65536 / std::max(kLeastPlate, value + kOffset)));
        });
  return scale;
}

// The largest of each kPool x kPool pixels.
cv::Mat pooled(const cv::Mat& mask) {
  static_assert(kPool == 2);
  constexpr int kStep = cv::v_uint8x16::nlanes;
  cv::Mat pool((mask.rows + 1) / 2, (mask.cols + 1) / 2, CV_8UC1);
  for (int y = 0; y < pool.rows; ++y) {
    const auto *upper = mask.ptr<std::uint8_t>(2 * y),
               *lower = mask.ptr<std::uint8_t>(std::min(2 * y + 1, mask.rows - 1));
    auto* to = pool.ptr<std::uint8_t>(y);
    int x = 0;
    for (; 2 * (x + kStep) <= mask.cols; x += kStep) {
      cv::v_uint8x16 a, b, c, d;
      cv::v_load_deinterleave(upper + 2 * x, a, b);
      cv::v_load_deinterleave(lower + 2 * x, c, d);
      cv::v_store(to + x, a | b | c | d);
    }
    for (; x < pool.cols; ++x) {
      const int right = std::min(2 * x + 1, mask.cols - 1);
      to[x] = upper[2 * x] | upper[right] | lower[2 * x] | lower[right];
    }
  }
  return pool;
}

// A lamp that no plate knows is white in all colours for the most part; `box`: of the piece, in pooled pixels.
bool is_lamp(const HalfPicture& half, const cv::Mat& labels, int piece, const cv::Rect& box) {
  constexpr int kWhite = kOverexposed * kHalfScale;
  int all = 0, white = 0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      if (labels.at<int>(y, x) != piece) continue;
      ++all;
      white += std::all_of(half.planes.begin(), half.planes.end(), [&](const cv::Mat& plane) {
        return plane.at<std::uint16_t>(kPool * y, kPool * x) >= kWhite;
      });
    }
  return 2 * white > all;
}

// Takes small pieces and lamps out of `inside`; returns what holds the rest, empty if nothing is left.
cv::Rect drop_stray_pieces(const HalfPicture& half, cv::Mat& inside) {
  cv::Mat labels, statistics, centres;
  const cv::Mat pool = pooled(inside);
  const int count = cv::connectedComponentsWithStats(pool, labels, statistics, centres, 8, CV_32S);
  const int smallest = std::max(2, static_cast<int>(pool.total()) / kSmallestPiece);
  std::vector<std::uint8_t> keep(static_cast<std::size_t>(count), 0);
  cv::Rect box;
  for (int piece = 1; piece < count; ++piece) {
    const int* found = statistics.ptr<int>(piece);
    if (found[cv::CC_STAT_AREA] < smallest) continue;
    const cv::Rect own(found[cv::CC_STAT_LEFT], found[cv::CC_STAT_TOP], found[cv::CC_STAT_WIDTH],
                       found[cv::CC_STAT_HEIGHT]);
    if (is_lamp(half, labels, piece, own)) continue;
    keep[static_cast<std::size_t>(piece)] = 255;
    box |= own;
  }
  box = cv::Rect(kPool * box.x, kPool * box.y, kPool * box.width, kPool * box.height) & cv::Rect({}, inside.size());
  for (int y = box.y; y < box.y + box.height; ++y) {
    const int* label = labels.ptr<int>(y / kPool);
    auto* pixel = inside.ptr<std::uint8_t>(y);
    for (int x = box.x; x < box.x + box.width; ++x) pixel[x] &= keep[static_cast<std::size_t>(label[x / kPool])];
  }
  return box;
}

// As chroma_key() does; `far`: the half picture's plane of the far channel.
void fill_holes(cv::Mat inside, const cv::Mat& far, int smallest) {
  cv::Mat labels, statistics, centres;
  const int count = cv::connectedComponentsWithStats(inside == 0, labels, statistics, centres, 4, CV_32S);
  for (int hole = 1; hole < count; ++hole) {
    const int* found = statistics.ptr<int>(hole);
    const cv::Rect box(found[cv::CC_STAT_LEFT], found[cv::CC_STAT_TOP], found[cv::CC_STAT_WIDTH],
                       found[cv::CC_STAT_HEIGHT]);
    const bool is_small = found[cv::CC_STAT_AREA] < smallest;
    const bool is_surrounded =
        box.x > 0 && box.y > 0 && box.x + box.width < inside.cols && box.y + box.height < inside.rows;
    if (!is_small && !is_surrounded) continue;
    const cv::Mat pixels = labels(box) == hole;
    const cv::Mat unlit = (far(box) <= kDarkest * kHalfScale) & pixels;
    if (is_small || 2 * cv::countNonZero(unlit) > found[cv::CC_STAT_AREA]) inside(box).setTo(255, pixels);
  }
}

}  // namespace

LiveKey::LiveKey(const cv::Mat& plate, PixelFormat format, const LiveKeyOptions& options)
    : size_(plate.size()), format_(format) {
  if (plate.type() != CV_8UC3 || plate.cols < 2 || plate.rows < 2)
    throw InvalidInput("the live key wants a plate of 8-bit red, green, blue");
  if (!options.stage.empty() && (options.stage.size() != size_ || options.stage.type() != CV_8UC1))
    throw InvalidInput("the stage's mask is of another size than the plate");
  const auto backdrop = options.backdrop ? options.backdrop : backdrop_of(plate);
  if (!backdrop) throw InvalidInput("the plate shows no screen's colour, neither blue nor green; light the screen");
  channels_ = key_channels(plate, *backdrop);
  const auto half = half_picture(plate, format);
  for (std::size_t c = 0; c < 3; ++c) scale_[c] = scale_of(half.planes[c]);
  if (!options.stage.empty()) cv::resize(options.stage, stage_, half.planes[0].size(), 0, 0, cv::INTER_NEAREST);
}

// By what each channel's ratio is multiplied so that the backdrop's median is 1: light drifts while lamps get warm.
std::array<std::uint16_t, 3> LiveKey::plate_light(const HalfPicture& half) const {
  std::array<std::vector<int>, 3> ratios;
  const auto own = static_cast<std::size_t>(channels_.own);
  for (int y = kLightStride / 2; y < half.planes[0].rows; y += kLightStride)
    for (int x = kLightStride / 2; x < half.planes[0].cols; x += kLightStride) {
      std::array<int, 3> value{};
      for (std::size_t c = 0; c < 3; ++c) value[c] = half.planes[c].at<std::uint16_t>(y, x) + kOffset;
      if (6 * value[own] < 7 * std::max(value[(own + 1) % 3], value[(own + 2) % 3])) continue;  // as fit_plate()
      for (std::size_t c = 0; c < 3; ++c) ratios[c].push_back(value[c] * scale_[c].at<std::uint16_t>(y, x) >> 16);
    }
  std::array<std::uint16_t, 3> light{kLightUnit, kLightUnit, kLightUnit};
  if (ratios[0].size() < kFewestLightPixels) return light;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto middle = ratios[c].begin() + static_cast<std::ptrdiff_t>(ratios[c].size() / 2);
    std::nth_element(ratios[c].begin(), middle, ratios[c].end());
    light[c] = static_cast<std::uint16_t>(std::clamp(kUnit * kLightUnit / std::max(1, *middle), kLightUnit / 2, 65535));
  }
  return light;
}

cv::Mat LiveKey::inside_of(const HalfPicture& half) const {
  const auto limit = limit_lines();
  const auto light = plate_light(half);
  cv::Mat inside(half.planes[0].size(), CV_8UC1, cv::Scalar(0));
  constexpr int kStep = cv::v_uint16x8::nlanes;
  const auto eight_at = [&](int y, int x) {
    const auto ratio_of = [&](int channel) {
      const auto c = static_cast<std::size_t>(channel);
      return in_light(ratio(half.planes[c].ptr<std::uint16_t>(y) + x, scale_[c].ptr<std::uint16_t>(y) + x), light[c]);
    };
    const auto own = ratio_of(channels_.own);
    const auto far_leads = ratio_of(channels_.far) > limit_of(own, limit);
    const auto near_leads = ratio_of(channels_.near) > cv::v_mul_hi(cv::v_shl<3>(own), cv::v_setall_u16(limit.top));
    const auto lit = cv::v_load(half.planes[static_cast<std::size_t>(channels_.far)].ptr<std::uint16_t>(y) + x) >
                     cv::v_setall_u16(static_cast<std::uint16_t>(kDarkest * kHalfScale));
    cv::v_pack_store(inside.ptr<std::uint8_t>(y) + x, (far_leads | near_leads) & lit);
  };
  if (inside.cols < kStep) return inside;
  for (int y = 0; y < inside.rows; ++y) {
    for (int x = 0; x + kStep <= inside.cols; x += kStep) eight_at(y, x);
    eight_at(y, inside.cols - kStep);
  }
  if (!stage_.empty()) inside &= stage_;
  return inside;
}

HalfMatte LiveKey::half(const Image& image) const {
  if (image.format != format_ || image.width != size_.width || image.height != size_.height)
    throw InvalidInput(fmt::format("the live key is for {} x {} pixels of {}, not {} x {} of {}", size_.width,
                                   size_.height, to_string(format_), image.width, image.height,
                                   to_string(image.format)));
  HalfMatte matte{.alpha = {}, .box = {}, .picture = half_picture(image)};
  cv::Mat inside = inside_of(matte.picture);
  const cv::Rect box = drop_stray_pieces(matte.picture, inside);
  if (box.empty()) return matte;
  const cv::Mat& far = matte.picture.planes[static_cast<std::size_t>(channels_.far)];
  fill_holes(inside(box), far(box), std::max(2, static_cast<int>(inside.total()) / kSmallestHole));
  matte.box = half_edge_box(box, inside.size());
  matte.alpha = half_edge_matte(matte.picture, inside, matte.box);
  return matte;
}

Matte LiveKey::operator()(const Image& image) const {
  const auto matte = half(image);
  cv::Mat whole = cv::Mat::zeros(size_, CV_8UC1);
  if (matte.box.empty()) return {whole};
  const cv::Rect doubled(2 * matte.box.x, 2 * matte.box.y, 2 * matte.box.width, 2 * matte.box.height);
  cv::Mat there = whole(doubled);
  cv::resize(matte.alpha, there, there.size(), 0, 0, cv::INTER_LINEAR);
  return {whole};
}

std::vector<Matte> key_live(std::span<const LiveKey> keys, std::span<const Image> images) {
  if (keys.size() != images.size())
    throw InvalidInput(fmt::format("{} live keys for {} images", keys.size(), images.size()));
  std::vector<Matte> mattes(keys.size());
  tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t i) { mattes[i] = keys[i](images[i]); });
  return mattes;
}

}  // namespace rotunda::capture
