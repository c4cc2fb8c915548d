#include "capture/matte/half_picture.h"

#include <algorithm>
#include <opencv2/core/hal/intrin.hpp>
#include <vector>

#include "capture/picture.h"

namespace rotunda::capture {
namespace {

// Where red stands in the 2 x 2 pixels that a mosaic repeats; blue stands across from it.
struct RedPlace {
  int right = 0, down = 0;
};

RedPlace red_place(BayerOrder order) {
  switch (order) {
    case BayerOrder::gr:
      return {1, 0};
    case BayerOrder::gb:
      return {0, 1};
    case BayerOrder::bg:
      return {1, 1};
    default:
      return {0, 0};
  }
}

bool is_mosaic8(PixelFormat format) {
  const auto layout = layout_of(format);
  return layout.order != BayerOrder::none && layout.packing == PixelPacking::bytes;
}

HalfPicture empty_half(int width, int height) {
  HalfPicture half;
  for (auto& plane : half.planes) plane.create(height / 2, width / 2, CV_16UC1);
  return half;
}

constexpr int kLanes = cv::v_uint16x8::nlanes;

// Of 2 x kLanes neighbours those that stand `right` in each pair.
cv::v_uint16x8 of_pairs(const std::uint8_t* row, int right) {
  cv::v_uint8x16 even, odd;
  cv::v_uint16x8 low, high;
  cv::v_load_deinterleave(row, even, odd);
  cv::v_expand(right == 0 ? even : odd, low, high);
  return low;
}

// Calls `lanes(x)` for kLanes pairs at a time, reading as many again beyond them, and `single(x)` for the rest.
template <class Lanes, class Single>
void for_pairs(int pairs, Lanes&& lanes, Single&& single) {
  int x = 0;
  for (; x + 2 * kLanes <= pairs; x += kLanes) lanes(x);
  for (; x < pairs; ++x) single(x);
}

// The photosites that stand `right` in each pair of two rows: three quarters of the nearer row, one of the farther, in
// 1/4 of a level.
void mix_rows(const std::uint8_t* near, const std::uint8_t* far, int right, std::uint16_t* out, int pairs) {
  for_pairs(
      pairs,
      [&](int x) {
        const auto nearer = of_pairs(near + 2 * x, right), farther = of_pairs(far + 2 * x, right);
        cv::v_store(out + x, nearer + cv::v_shl<1>(nearer) + farther);
      },
      [&](int x) { out[x] = static_cast<std::uint16_t>(3 * near[2 * x + right] + far[2 * x + right]); });
}

// To where the pairs' middles are: the nearer photosite counts three quarters, the one `beyond` it one.
void mix_columns(const std::uint16_t* mixed, int beyond, std::uint16_t* out, int pairs) {
  const int first = beyond < 0 ? 1 : 0, last = beyond < 0 ? pairs : pairs - 1;
  if (first == 1) out[0] = static_cast<std::uint16_t>(4 * mixed[0]);
  int x = first;
  for (; x + kLanes <= last; x += kLanes) {
    const auto nearer = cv::v_load(mixed + x);
    cv::v_store(out + x, nearer + cv::v_shl<1>(nearer) + cv::v_load(mixed + x + beyond));
  }
  for (; x < last; ++x) out[x] = static_cast<std::uint16_t>(3 * mixed[x] + mixed[x + beyond]);
  if (last < pairs) out[last] = static_cast<std::uint16_t>(4 * mixed[last]);
}

void add_greens(const std::uint8_t* upper, const std::uint8_t* lower, int right, std::uint16_t* out, int pairs) {
  for_pairs(
      pairs,
      [&](int x) {
        cv::v_store(out + x, cv::v_shl<3>(of_pairs(upper + 2 * x, right) + of_pairs(lower + 2 * x, 1 - right)));
      },
      [&](int x) { out[x] = static_cast<std::uint16_t>(8 * (upper[2 * x + right] + lower[2 * x + 1 - right])); });
}

// `samples`: the mosaic, CV_8UC1.
HalfPicture half_of_mosaic(const cv::Mat& samples, RedPlace red) {
  HalfPicture half = empty_half(samples.cols, samples.rows);
  const int pairs = samples.cols / 2, rows = samples.rows / 2;
  std::vector<std::uint16_t> mixed(static_cast<std::size_t>(pairs));
  const auto colour = [&](int y, RedPlace place, cv::Mat& plane) {
    const int near = 2 * y + place.down, beyond = near + (place.down == 0 ? 2 : -2);
    const bool outside = beyond < 0 || beyond >= samples.rows;
    mix_rows(samples.ptr(near), samples.ptr(outside ? near : beyond), place.right, mixed.data(), pairs);
    mix_columns(mixed.data(), place.right == 0 ? 1 : -1, plane.ptr<std::uint16_t>(y), pairs);
  };
  for (int y = 0; y < rows; ++y) {
    colour(y, red, half.planes[0]);
    colour(y, {1 - red.right, 1 - red.down}, half.planes[2]);
    const int green_in_upper = red.down == 0 ? 1 - red.right : red.right;
    add_greens(samples.ptr(2 * y), samples.ptr(2 * y + 1), green_in_upper, half.planes[1].ptr<std::uint16_t>(y), pairs);
  }
  return half;
}

HalfPicture half_of_rgb(const cv::Mat& rgb) {
  HalfPicture half = empty_half(rgb.cols, rgb.rows);
  for (int y = 0; y < rgb.rows / 2; ++y) {
    const auto *upper = rgb.ptr(2 * y), *lower = rgb.ptr(2 * y + 1);
    std::array<std::uint16_t*, 3> out{};
    for (std::size_t c = 0; c < 3; ++c) out[c] = half.planes[c].ptr<std::uint16_t>(y);
    for (int x = 0; x < rgb.cols / 2; ++x, upper += 6, lower += 6)
      for (std::size_t c = 0; c < 3; ++c)
        out[c][x] = static_cast<std::uint16_t>(4 * (upper[c] + upper[c + 3] + lower[c] + lower[c + 3]));
  }
  return half;
}

}  // namespace

HalfPicture half_picture(const Image& image) {
  if (!is_mosaic8(image.format)) return half_of_rgb(to_rgb(image));
  // const_cast: cv::Mat has no read-only view; nothing below writes through it.
  const cv::Mat samples(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.get()));
  return half_of_mosaic(samples, red_place(layout_of(image.format).order));
}

HalfPicture half_picture(const cv::Mat& rgb, PixelFormat format) {
  if (!is_mosaic8(format)) return half_of_rgb(rgb);
  const RedPlace red = red_place(layout_of(format).order);
  cv::Mat samples(rgb.size(), CV_8UC1);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const bool red_row = (y & 1) == red.down, red_column = (x & 1) == red.right;
      samples.at<std::uint8_t>(y, x) = rgb.at<cv::Vec3b>(y, x)[red_row == red_column ? (red_row ? 0 : 2) : 1];
    }
  return half_of_mosaic(samples, red);
}

}  // namespace rotunda::capture
