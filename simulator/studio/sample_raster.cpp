#include "simulator/studio/sample_raster.h"

#include <algorithm>
#include <cmath>

namespace rotunda::simulator {
namespace {

constexpr float kSeam = 1e-4F;  // neighbours overlap by so many samples: rounding leaves no holes

// The least whole number not below x, for 0 <= x; no call into the mathematics library.
int rounded_up(float x) {
  const int down = static_cast<int>(x);
  return down + (static_cast<float>(down) < x ? 1 : 0);
}

// Samples whose centres lie within [low, high], of so many.
std::array<int, 2> centres_within(float low, float high, int count) {
  const auto most = static_cast<float>(count);
  const float first = std::clamp(low - 0.5F - kSeam, 0.0F, most), last = std::clamp(high + 0.5F + kSeam, 0.0F, most);
  return {rounded_up(first), static_cast<int>(last)};
}

struct Span {
  float low, high;
  void cut(const SampleCorner& a, const SampleCorner& b, float y) {
    if ((a.y <= y) == (b.y <= y)) return;
    const float x = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

}  // namespace

float doubled_area(const SampleTriangle& t) {
  return (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[1].y - t[0].y) * (t[2].x - t[0].x);
}

Eigen::Vector3f weights_at(const SampleTriangle& t, float x, float y) {
  const auto opposite = [&](const SampleCorner& a, const SampleCorner& b) {
    return (a.x - x) * (b.y - y) - (a.y - y) * (b.x - x);
  };
  const Eigen::Vector3f flat(opposite(t[1], t[2]) * t[0].nearness, opposite(t[2], t[0]) * t[1].nearness,
                             opposite(t[0], t[1]) * t[2].nearness);
  const float sum = flat.sum();
  return sum == 0.0F ? Eigen::Vector3f::UnitX() : Eigen::Vector3f(flat / sum);
}

SampleRaster::SampleRaster(int columns, int rows)
    : columns_(columns),
      rows_(rows),
      nearest_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0.0F),
      numbers_(nearest_.size(), 0),
      touched_(static_cast<std::size_t>(rows), {columns, 0}) {}

void SampleRaster::add(const SampleTriangle& t, std::uint32_t number) {
  const float area = doubled_area(t);
  if (!(std::abs(area) > 1e-12F)) return;
  const auto [low, high] = std::minmax({t[0].y, t[1].y, t[2].y});
  const auto [from, to] = centres_within(low, high, rows_);
  // The plane of 1 / depth, which is flat in the picture.
  const float u = t[1].nearness - t[0].nearness, v = t[2].nearness - t[0].nearness;
  const float across = (u * (t[2].y - t[0].y) - v * (t[1].y - t[0].y)) / area;
  const float down = (v * (t[1].x - t[0].x) - u * (t[2].x - t[0].x)) / area;
  for (int row = from; row < to; ++row) {
    const float y = static_cast<float>(row) + 0.5F;
    Span span{1e9F, -1e9F};
    for (std::size_t i = 0; i < 3; ++i) span.cut(t[i], t[(i + 1) % 3], y);
    const auto [first, last] = centres_within(span.low, span.high, columns_);
    if (first >= last) continue;
    auto& touched = touched_[static_cast<std::size_t>(row)];
    touched = {std::min(touched[0], first), std::max(touched[1], last)};
    const auto start = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
    float nearness = t[0].nearness + across * (static_cast<float>(first) + 0.5F - t[0].x) + down * (y - t[0].y);
    for (int column = first; column < last; ++column, nearness += across) {
      const std::size_t at = start + static_cast<std::size_t>(column);
      if (nearness <= nearest_[at]) continue;
      nearest_[at] = nearness;
      numbers_[at] = number;
    }
  }
}

void SampleRaster::clear() {
  for (int row = 0; row < rows_; ++row) {
    auto& [first, last] = touched_[static_cast<std::size_t>(row)];
    if (first < last) {
      const auto start = static_cast<std::ptrdiff_t>(row) * columns_;
      std::fill(nearest_.begin() + start + first, nearest_.begin() + start + last, 0.0F);
      std::fill(numbers_.begin() + start + first, numbers_.begin() + start + last, 0U);
    }
    first = columns_;
    last = 0;
  }
}

}  // namespace rotunda::simulator
