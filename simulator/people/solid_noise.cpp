#include "simulator/people/solid_noise.h"

#include <array>
#include <cmath>

namespace rotunda::simulator {
namespace {

std::uint32_t mix(std::uint32_t h) {  // finaliser of MurmurHash3
  h ^= h >> 16;
  h *= 0x85ebca6bU;
  h ^= h >> 13;
  h *= 0xc2b2ae35U;
  return h ^ (h >> 16);
}

std::uint32_t hashed(std::uint32_t h, std::int64_t v) {
  return mix(h ^ (static_cast<std::uint32_t>(v) * 0x9e3779b9U + 0x7f4a7c15U));
}

std::uint32_t hash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
  return hashed(hashed(hashed(seed, x), y), z);
}

// One of the twelve edge directions of a cube (Perlin, "Improving noise", 2002).
double gradient_dot(std::uint32_t h, double x, double y, double z) {
  const std::uint32_t g = h & 15U;
  const double u = g < 8 ? x : y;
  const double v = g < 4 ? y : (g == 12 || g == 14 ? x : z);
  return ((g & 1U) ? -u : u) + ((g & 2U) ? -v : v);
}

double fade(double t) {
  return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

}  // namespace

double solid_noise(const Eigen::Vector3d& p, std::uint32_t seed) {
  const Eigen::Vector3d base = p.array().floor();
  const Eigen::Vector3d f = p - base;
  const auto x = static_cast<std::int64_t>(base.x()), y = static_cast<std::int64_t>(base.y()),
             z = static_cast<std::int64_t>(base.z());
  const double u = fade(f.x()), v = fade(f.y()), w = fade(f.z());
  double sum = 0.0;
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t column = hashed(seed, x + i);
    for (int j = 0; j < 2; ++j) {
      const std::uint32_t row = hashed(column, y + j);
      const double share = (i ? u : 1.0 - u) * (j ? v : 1.0 - v);
      for (int k = 0; k < 2; ++k)
        sum += share * (k ? w : 1.0 - w) * gradient_dot(hashed(row, z + k), f.x() - i, f.y() - j, f.z() - k);
    }
  }
  return sum;
}

double fractal_noise(const Eigen::Vector3d& p, int octaves, std::uint32_t seed) {
  double sum = 0.0, height = 0.5, frequency = 1.0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += height * solid_noise(p * frequency, seed + static_cast<std::uint32_t>(octave));
    height *= 0.5;
    frequency *= 2.0;
  }
  return sum * 1.4;
}

double hashed_unit(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
  return hash(x, y, z, seed) * 0x1p-32;
}

}  // namespace rotunda::simulator
