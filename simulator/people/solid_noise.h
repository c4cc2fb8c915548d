#pragma once
// Smooth random functions of space (Perlin, "An image synthesizer", 1985), equal on every machine for one seed.
#include <Eigen/Core>
#include <cstdint>

namespace rotunda::simulator {

// Gradient noise with a lattice of one unit; about -1 to 1, 0 on the lattice points; repeats every 256 units.
double solid_noise(const Eigen::Vector3d& p, std::uint32_t seed);

// Sum of octaves, each of twice the frequency and half the height of the one before; about -1 to 1.
double fractal_noise(const Eigen::Vector3d& p, int octaves, std::uint32_t seed);

// Uniform in [0, 1), a fixed function of its integers.
double hashed_unit(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed);

}  // namespace rotunda::simulator
