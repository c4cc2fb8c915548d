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

std::uint32_t hash(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) {
  std::uint32_t h = seed;
  for (const std::int64_t v : {x, y, z}) h = mix(h ^ (static_cast<std::uint32_t>(v) * 0x9e3779b9U + 0x7f4a7c15U));
  return h;
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
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const double weight = (i ? fade(f.x()) : 1.0 - fade(f.x())) * (j ? fade(f.y()) : 1.0 - fade(f.y())) *
                          (k ? fade(f.z()) : 1.0 - fade(f.z()));
    sum += weight * gradient_dot(hash(x + i, y + j, z + k, seed), f.x() - i, f.y() - j, f.z() - k);
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
