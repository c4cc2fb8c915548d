#pragma once
// What a take keeps beside the pixels of every frame: BlockAdditional data (id 1) of its Matroska block, because
// Matroska's own clock has only milliseconds. 44 bytes, little-endian; docs/take-format.md has the table.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "capture/frame.h"

namespace rotunda::capture {

struct FrameRecord {
  std::uint64_t trigger = 0;
  Timestamp trigger_time;  // FrameSet::time
  Timestamp exposure_start;
  std::chrono::nanoseconds exposure{};
  std::uint32_t pixels_crc = 0;  // CRC-32C of the pixels as decoded: rows top to bottom, no padding

  friend bool operator==(const FrameRecord&, const FrameRecord&) = default;
};

inline constexpr std::size_t kFrameRecordSize = 44;

std::array<std::uint8_t, kFrameRecordSize> encode(const FrameRecord& record);
// Nothing if it is too short, of another version, or its own CRC does not hold.
std::optional<FrameRecord> decode_frame_record(std::span<const std::uint8_t> bytes);

}  // namespace rotunda::capture
