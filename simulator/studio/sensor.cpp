#include "simulator/studio/sensor.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

constexpr int kCurveSize = 8192;
constexpr std::uint32_t kNormals = 1U << 14;

double srgb_encode(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

const std::array<std::uint8_t, kCurveSize>& gamma_curve() {
  static const auto curve = [] {
    std::array<std::uint8_t, kCurveSize> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
      table[i] = static_cast<std::uint8_t>(255.0 * srgb_encode(static_cast<double>(i) / (kCurveSize - 1)) + 0.5);
    return table;
  }();
  return curve;
}

// Normally distributed numbers by the inverse of their distribution: equal on every machine, unlike the library's.
const std::vector<float>& normals() {
  static const auto table = [] {
    std::vector<float> values(kNormals);
    std::mt19937 random(20221);
    const auto uniform = [&] { return (static_cast<double>(random()) + 0.5) * 0x1p-32; };
    for (std::size_t i = 0; i + 1 < values.size(); i += 2) {  // Box and Muller 1958
      const double u = uniform(), v = uniform();
      const double r = std::sqrt(-2.0 * std::log(u)), angle = 2.0 * std::numbers::pi * v;
      values[i] = static_cast<float>(r * std::cos(angle));
      values[i + 1] = static_cast<float>(r * std::sin(angle));
    }
    return values;
  }();
  return table;
}

// Marsaglia's xorshift (2003); state never zero.
struct Xorshift {
  std::uint32_t state;
  std::uint32_t next() {
    state ^= state << 13;
    state ^= state >> 17;
    return state ^= state << 5;
  }
};

cv::Vec3f channel_gains(std::size_t camera, const SensorOptions& options) {
  const auto spread = [&](std::int64_t what) {
    return 2.0 * hashed_unit(static_cast<std::int64_t>(camera), what, 0, options.seed) - 1.0;
  };
  const double gain = 1.0 + options.gain_spread * spread(1);
  return {static_cast<float>(gain * (1.0 + options.balance_spread * spread(2))), static_cast<float>(gain),
          static_cast<float>(gain * (1.0 + options.balance_spread * spread(3)))};
}

}  // namespace

cv::Mat expose(const cv::Mat& linear, std::size_t camera, std::uint64_t frame, const SensorOptions& options) {
  const cv::Vec3f gains = channel_gains(camera, options);
  const auto shot = static_cast<float>(1.0 / options.full_well);
  const auto read = static_cast<float>(std::pow(options.read_noise / options.full_well, 2));
  const auto& curve = gamma_curve();
  const auto& normal = normals();
  const float middle_x = 0.5F * static_cast<float>(linear.cols - 1),
              middle_y = 0.5F * static_cast<float>(linear.rows - 1);
  const float darkening = static_cast<float>(options.vignetting) / (middle_x * middle_x + middle_y * middle_y);
  cv::Mat picture(linear.size(), CV_8UC3);
  tbb::parallel_for(0, linear.rows, [&](int y) {
    const double draw =
        hashed_unit(static_cast<std::int64_t>(camera), static_cast<std::int64_t>(frame), y, options.seed + 9);
    Xorshift random{static_cast<std::uint32_t>(draw * 4294967295.0) | 1U};
    const auto* in = linear.ptr<cv::Vec3f>(y);
    auto* out = picture.ptr<cv::Vec3b>(y);
    const float dy = static_cast<float>(y) - middle_y;
    for (int x = 0; x < linear.cols; ++x) {
      const float dx = static_cast<float>(x) - middle_x;
      const float lens = 1.0F - darkening * (dx * dx + dy * dy);
      for (int c = 0; c < 3; ++c) {
        const float light = in[x][c] * lens * gains[c];
        const float noisy = light + std::sqrt(light * shot + read) * normal[random.next() >> 18];
        out[x][c] = curve[static_cast<std::size_t>(std::clamp(noisy, 0.0F, 1.0F) * (kCurveSize - 1) + 0.5F)];
      }
    }
  });
  return picture;
}

}  // namespace rotunda::simulator
