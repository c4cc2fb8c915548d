#include "simulator/studio/sensor_response.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

double srgb_encode(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

std::vector<std::uint16_t> curve_with(double balance) {
  std::vector<std::uint16_t> table(kFullScale + 1);
  for (int code = 0; code <= kFullScale; ++code)
    table[static_cast<std::size_t>(code)] =
        static_cast<std::uint16_t>(kFullScale * srgb_encode(std::min(1.0, balance * code / kFullScale)) + 0.5);
  return table;
}

}  // namespace

double deviation(std::size_t camera, std::int64_t property, std::uint32_t seed) {
  return 2.0 * hashed_unit(static_cast<std::int64_t>(camera), property, 0, seed) - 1.0;
}

SensorResponse sensor_response(const SensorOptions& options, std::size_t camera, double gain_db,
                               const std::array<double, 3>& balance) {
  SensorResponse response{
      .read_noise = static_cast<float>(options.read_noise),
      .codes_per_electron = static_cast<float>(kFullScale / options.full_well * std::pow(10.0, gain_db / 20.0)),
      .curve = {}};
  for (std::size_t c = 0; c < 3; ++c) {
    const double residue = c == 1 ? 0.0 : options.balance_spread * deviation(camera, c == 0 ? 2 : 3, options.seed);
    response.curve[c] = curve_with(balance[c] * (1.0 + residue) / kFilterResponse[c]);
  }
  return response;
}

const std::vector<float>& normals() {
  static const auto table = [] {
    std::vector<float> values(1U << kNormalBits);
    std::mt19937 random(20221);
    const auto uniform = [&] { return (static_cast<double>(random()) + 0.5) * 0x1p-32; };
    double squares = 0.0;
    for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
      const double r = std::sqrt(-2.0 * std::log(uniform())), angle = 2.0 * std::numbers::pi * uniform();
      values[i] = static_cast<float>(r * std::cos(angle));
      values[i + 1] = static_cast<float>(r * std::sin(angle));
      squares += r * r;
    }
    for (float& value : values) value *= static_cast<float>(std::sqrt(static_cast<double>(values.size()) / squares));
    return values;
  }();
  return table;
}

RowNoise::RowNoise(std::size_t camera, std::uint64_t frame, int row, std::uint32_t seed)
    : RowNoise(hashed_unit(static_cast<std::int64_t>(camera), static_cast<std::int64_t>(frame), row, seed + 9)) {}

}  // namespace rotunda::simulator
