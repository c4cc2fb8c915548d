#include "capture/matte/half_picture.h"

#include <algorithm>
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

// Three quarters of the nearer row, one of the farther: 1/4 of a level.
void mix_rows(const std::uint8_t* near, const std::uint8_t* far, std::uint16_t* out, int width) {
  for (int x = 0; x < width; ++x) out[x] = static_cast<std::uint16_t>(3 * near[x] + far[x]);
}

// The photosites of a colour that stand `right` in each pair, to where the pairs' middles are: the nearer counts three
// quarters, the one beyond it one.
void mix_columns(const std::uint16_t* row, int right, std::uint16_t* out, int pairs) {
  const int beyond = right == 0 ? 2 : -2;
  const int first = right == 0 ? 0 : 1, last = right == 0 ? pairs - 1 : pairs;
  if (first == 1) out[0] = static_cast<std::uint16_t>(4 * row[right]);
  const std::uint16_t* at = row + right;
  for (int x = first; x < last; ++x) out[x] = static_cast<std::uint16_t>(3 * at[2 * x] + at[2 * x + beyond]);
  if (last < pairs) out[last] = static_cast<std::uint16_t>(4 * at[2 * last]);
}

void add_greens(const std::uint8_t* upper, const std::uint8_t* lower, int right_in_upper, std::uint16_t* out,
                int pairs) {
  const std::uint8_t* a = upper + right_in_upper;
  const std::uint8_t* b = lower + 1 - right_in_upper;
  for (int x = 0; x < pairs; ++x) out[x] = static_cast<std::uint16_t>(8 * (a[2 * x] + b[2 * x]));
}

// `samples`: the mosaic, CV_8UC1.
HalfPicture half_of_mosaic(const cv::Mat& samples, RedPlace red) {
  HalfPicture half = empty_half(samples.cols, samples.rows);
  const int pairs = samples.cols / 2, rows = samples.rows / 2;
  std::vector<std::uint16_t> mixed(static_cast<std::size_t>(samples.cols));
  const auto colour = [&](int y, RedPlace place, cv::Mat& plane) {
    const int near = 2 * y + place.down, beyond = near + (place.down == 0 ? 2 : -2);
    const bool outside = beyond < 0 || beyond >= samples.rows;
    mix_rows(samples.ptr(near), samples.ptr(outside ? near : beyond), mixed.data(), 2 * pairs);
    mix_columns(mixed.data(), place.right, plane.ptr<std::uint16_t>(y), pairs);
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
    const auto *upper = rgb.ptr<cv::Vec3b>(2 * y), *lower = rgb.ptr<cv::Vec3b>(2 * y + 1);
    for (int x = 0; x < rgb.cols / 2; ++x)
      for (int c = 0; c < 3; ++c)
        half.planes[static_cast<std::size_t>(c)].at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(
            4 * (upper[2 * x][c] + upper[2 * x + 1][c] + lower[2 * x][c] + lower[2 * x + 1][c]));
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
