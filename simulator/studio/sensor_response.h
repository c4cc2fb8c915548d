#pragma once
// How one camera turns electrons into codes, and the noise it does so with: EMVA 1288's linear model with what differs
// from camera to camera. Sensor exposes light by it; ReExposure finds its way back by it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "simulator/studio/sensor.h"

namespace rotunda::simulator {

inline constexpr int kFullScale = 4095;  // of the converter

// `balance`: factors on red, green and blue, those of the settings included. Cameras differ a little beyond.
SensorResponse sensor_response(const SensorOptions& options, std::size_t camera, double gain_db,
                               const std::array<double, 3>& balance);

// Of studio light through the filters, beside green's.
inline constexpr std::array<double, 3> kFilterResponse{0.62, 1.0, 0.74};

// Uniform from -1 to 1: how a camera differs from the others in one property.
double deviation(std::size_t camera, std::int64_t property, std::uint32_t seed);

// Normally distributed numbers of variance 1, by Box and Muller (1958): equal on every machine, unlike the library's.
inline constexpr unsigned kNormalBits = 14;
const std::vector<float>& normals();  // 1 << kNormalBits of them

// The noise of one row of a camera's picture: a normal for each channel of each pixel, from left to right.
// Marsaglia's xorshift (2003); state never zero.
class RowNoise {
 public:
  explicit RowNoise(double unit) : state_(static_cast<std::uint32_t>(unit * 4294967295.0) | 1U) {}
  RowNoise(std::size_t camera, std::uint64_t frame, int row, std::uint32_t seed);

  unsigned next_index() {  // of normals()
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return state_ >> (32 - kNormalBits);
  }

 private:
  std::uint32_t state_;
};

}  // namespace rotunda::simulator
