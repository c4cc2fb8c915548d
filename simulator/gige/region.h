#pragma once
// The part of the sensor a camera reads out. Pure.
#include <cstdint>
#include <span>
#include <vector>

namespace rotunda::simulator {

struct Region {
  std::uint32_t width = 0, height = 0, offset_x = 0, offset_y = 0;  // pixels
  friend bool operator==(const Region&, const Region&) = default;
};

// The region's pixels out of a picture `sensor_width` wide whose pixels take `bits_per_pixel`, rows one after another
// without padding. The region lies within the picture; its rows begin and end with whole bytes.
std::vector<std::uint8_t> read_out(std::span<const std::uint8_t> picture, std::uint32_t sensor_width,
                                   std::uint32_t bits_per_pixel, const Region& region);

}  // namespace rotunda::simulator
