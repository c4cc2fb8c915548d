#include "simulator/gige/region.h"

#include <cassert>

namespace rotunda::simulator {

std::vector<std::uint8_t> read_out(std::span<const std::uint8_t> picture, std::uint32_t sensor_width,
                                   std::uint32_t bits_per_pixel, const Region& region) {
  const auto bytes_of = [&](std::size_t pixels) {
    assert(pixels * bits_per_pixel % 8 == 0);
    return pixels * bits_per_pixel / 8;
  };
  std::vector<std::uint8_t> pixels;
  pixels.reserve(bytes_of(static_cast<std::size_t>(region.width) * region.height));
  for (std::uint32_t y = 0; y < region.height; ++y) {
    const std::size_t first = static_cast<std::size_t>(region.offset_y + y) * sensor_width + region.offset_x;
    const auto row = picture.subspan(bytes_of(first), bytes_of(region.width));
    pixels.insert(pixels.end(), row.begin(), row.end());
  }
  return pixels;
}

}  // namespace rotunda::simulator
