#pragma once
// CRC-32C (Castagnoli, RFC 3720 B.4), the check sum of frames in a take. Uses SSE 4.2 where the processor has it.
#include <cstdint>
#include <span>

namespace rotunda::capture {

std::uint32_t crc32c(std::span<const std::uint8_t> bytes);

}  // namespace rotunda::capture
