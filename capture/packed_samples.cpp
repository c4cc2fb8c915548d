#include "capture/packed_samples.h"

#include <algorithm>
#include <array>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Samples = std::span<const std::uint16_t>;

std::uint16_t word(unsigned value) {
  return static_cast<std::uint16_t>(value);
}
std::uint8_t low(unsigned value) {
  return static_cast<std::uint8_t>(value & 0xFFU);
}

// One group of pixels each: `in` and `out` are exactly as long as it.
void unpack_words(Bytes in, std::span<std::uint16_t> out) {
  out[0] = word(in[0] | static_cast<unsigned>(in[1]) << 8U);
}
void pack_words(Samples in, std::span<std::uint8_t> out) {
  out[0] = low(in[0]);
  out[1] = low(in[0] >> 8U);
}

// PFNC 12p: the first pixel's low byte, its high and the second's low nibble, the second's high byte.
void unpack_pfnc_12p(Bytes in, std::span<std::uint16_t> out) {
  out[0] = word(in[0] | (in[1] & 0xFU) << 8U);
  out[1] = word(in[1] >> 4U | static_cast<unsigned>(in[2]) << 4U);
}
void pack_pfnc_12p(Samples in, std::span<std::uint8_t> out) {
  out[0] = low(in[0]);
  out[1] = low((in[0] >> 8U & 0xFU) | static_cast<unsigned>(in[1]) << 4U);
  out[2] = low(in[1] >> 4U);
}

// MIPI CSI-2: the pixels' high eight bits each, then the low bits of all, first pixel lowest.
void unpack_csi2_10p(Bytes in, std::span<std::uint16_t> out) {
  for (unsigned i = 0; i < 4; ++i) out[i] = word(static_cast<unsigned>(in[i]) << 2U | (in[4] >> (2 * i) & 0x3U));
}
void pack_csi2_10p(Samples in, std::span<std::uint8_t> out) {
  unsigned rest = 0;
  for (unsigned i = 0; i < 4; ++i) {
    out[i] = low(in[i] >> 2U);
    rest |= (in[i] & 0x3U) << (2 * i);
  }
  out[4] = low(rest);
}
void unpack_csi2_12p(Bytes in, std::span<std::uint16_t> out) {
  for (unsigned i = 0; i < 2; ++i) out[i] = word(static_cast<unsigned>(in[i]) << 4U | (in[2] >> (4 * i) & 0xFU));
}
void pack_csi2_12p(Samples in, std::span<std::uint8_t> out) {
  for (unsigned i = 0; i < 2; ++i) out[i] = low(in[i] >> 4U);
  out[2] = low((in[0] & 0xFU) | (in[1] & 0xFU) << 4U);
}

// A packing: so many samples in so many bytes, and how a group goes one way and the other.
template <std::size_t kSamples, std::size_t kBytes, auto kUnpack, auto kPack>
struct Packing {
  static std::vector<std::uint16_t> unpacked(Bytes bytes, std::size_t samples) {
    const std::size_t groups = (samples + kSamples - 1) / kSamples;
    const bool partial = samples % kSamples != 0;  // an odd number of 12p pixels: the last byte need not be there
    if (bytes.size() + (partial ? 1 : 0) < groups * kBytes) throw InvalidInput("too few bytes for the samples");
    std::vector<std::uint16_t> out(groups * kSamples);
    const std::size_t whole = std::min(groups, bytes.size() / kBytes);
    for (std::size_t i = 0; i < whole; ++i)
      kUnpack(bytes.subspan(i * kBytes, kBytes), std::span(out).subspan(i * kSamples, kSamples));
    if (whole < groups) {
      std::array<std::uint8_t, kBytes> last{};
      std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(whole * kBytes), bytes.end(), last.begin());
      kUnpack(last, std::span(out).subspan(whole * kSamples, kSamples));
    }
    out.resize(samples);
    return out;
  }

  static std::vector<std::uint8_t> packed(Samples samples) {
    if (samples.size() % kSamples != 0) throw InvalidInput("the samples do not fill their last bytes");
    const std::size_t groups = samples.size() / kSamples;
    std::vector<std::uint8_t> out(groups * kBytes);
    for (std::size_t i = 0; i < groups; ++i)
      kPack(samples.subspan(i * kSamples, kSamples), std::span(out).subspan(i * kBytes, kBytes));
    return out;
  }
};

using Words = Packing<1, 2, unpack_words, pack_words>;
using Pfnc12p = Packing<2, 3, unpack_pfnc_12p, pack_pfnc_12p>;
using Csi210p = Packing<4, 5, unpack_csi2_10p, pack_csi2_10p>;
using Csi212p = Packing<2, 3, unpack_csi2_12p, pack_csi2_12p>;

// What `work` makes of the packing's type.
template <class Work>
auto with_packing(PixelPacking packing, Work work) {
  switch (packing) {
    case PixelPacking::words:
      return work(Words());
    case PixelPacking::pfnc_12p:
      return work(Pfnc12p());
    case PixelPacking::csi2_10p:
      return work(Csi210p());
    case PixelPacking::csi2_12p:
      return work(Csi212p());
    default:
      throw InvalidInput("this packing has no samples of more than eight bits");
  }
}

}  // namespace

std::vector<std::uint16_t> unpack_samples(std::span<const std::uint8_t> bytes, std::size_t samples,
                                          PixelPacking packing) {
  return with_packing(packing, [&](auto how) { return how.unpacked(bytes, samples); });
}

std::vector<std::uint8_t> pack_samples(std::span<const std::uint16_t> samples, PixelPacking packing) {
  return with_packing(packing, [&](auto how) { return how.packed(samples); });
}

}  // namespace rotunda::capture
