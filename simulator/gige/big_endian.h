#pragma once
// Network byte order, as every field of GVCP, GVSP and the bootstrap registers has it.
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

namespace rotunda::simulator {

// The unsigned integer at `offset`; the caller has checked that it lies within `bytes`.
template <class Unsigned>
Unsigned load_be(std::span<const std::uint8_t> bytes, std::size_t offset) {
  assert(offset + sizeof(Unsigned) <= bytes.size());
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) value = (value << 8) | bytes[offset + i];
  return static_cast<Unsigned>(value);
}

template <class Unsigned>
void store_be(std::span<std::uint8_t> bytes, std::size_t offset, Unsigned value) {
  assert(offset + sizeof(Unsigned) <= bytes.size());
  std::uint64_t rest = value;
  for (std::size_t i = sizeof(Unsigned); i-- > 0; rest >>= 8) bytes[offset + i] = static_cast<std::uint8_t>(rest);
}

}  // namespace rotunda::simulator
