#include "simulator/people/solid_noise.h"

#include <array>
#include <cmath>

namespace rotunda::simulator {
namespace {

constexpr std::uint32_t mix(std::uint32_t h) {  // finaliser of MurmurHash3
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
double gradient_dot(std::uint8_t h, double x, double y, double z) {
  const unsigned g = h & 15U;
  const double u = g < 8 ? x : y;
  const double v = g < 4 ? y : (g == 12 || g == 14 ? x : z);
  return ((g & 1U) ? -u : u) + ((g & 2U) ? -v : v);
}

double fade(double t) {
  return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

// A shuffle of 0 to 255, twice in a row. Noise is most of what a person costs to build: three look-ups a corner are a
// fifth of three hashes, and the lattice repeats after 256 units only.
constexpr std::array<std::uint8_t, 512> shuffled() {
  std::array<std::uint8_t, 512> table{};
  for (std::size_t i = 0; i < 256; ++i) table[i] = static_cast<std::uint8_t>(i);
  for (std::size_t i = 255; i > 0; --i) {
    const std::size_t j = mix(static_cast<std::uint32_t>(i) * 0x9e3779b9U) % (i + 1);
    const std::uint8_t kept = table[i];
    table[i] = table[j];
    table[j] = kept;
  }
  for (std::size_t i = 0; i < 256; ++i) table[256 + i] = table[i];
  return table;
}
constexpr auto kShuffled = shuffled();

// The lattice points about a coordinate, and how far beyond the first it lies.
struct Between {
  std::uint8_t low, high;
  double beyond, share;  // share: of the second point
  Between(double x, std::uint32_t offset) {
    const double floor = std::floor(x);
    low = static_cast<std::uint8_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(floor)) + offset);
    high = static_cast<std::uint8_t>(low + 1);
    beyond = x - floor;
    share = fade(beyond);
  }
};

double blend(double a, double b, double share) {
  return a + share * (b - a);
}

}  // namespace

double solid_noise(const Eigen::Vector3d& p, std::uint32_t seed) {
  const std::uint32_t offset = mix(seed);
  const Between x(p.x(), offset), y(p.y(), offset >> 8), z(p.z(), offset >> 16);
  const auto along_z = [&](std::size_t row, double dx, double dy) {
    return blend(gradient_dot(kShuffled[row + z.low], dx, dy, z.beyond),
                 gradient_dot(kShuffled[row + z.high], dx, dy, z.beyond - 1.0), z.share);
  };
  const auto along_y = [&](std::size_t column, double dx) {
    return blend(along_z(kShuffled[column + y.low], dx, y.beyond),
                 along_z(kShuffled[column + y.high], dx, y.beyond - 1.0), y.share);
  };
  return blend(along_y(kShuffled[x.low], x.beyond), along_y(kShuffled[x.high], x.beyond - 1.0), x.share);
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
