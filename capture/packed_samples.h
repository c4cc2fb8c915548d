#pragma once
// Samples of 10 and 12 bits out of the bytes a camera packs them into (frame.h, PixelPacking), and back. Both ways are
// exact: pack_samples(unpack_samples(b)) is b, for whole groups of pixels.
#include <cstdint>
#include <span>
#include <vector>

#include "capture/frame.h"

namespace rotunda::capture {

// words, pfnc_12p, csi2_10p or csi2_12p; throws InvalidInput for another packing or too few bytes.
std::vector<std::uint16_t> unpack_samples(std::span<const std::uint8_t> bytes, std::size_t samples,
                                          PixelPacking packing);
std::vector<std::uint8_t> pack_samples(std::span<const std::uint16_t> samples, PixelPacking packing);

}  // namespace rotunda::capture
