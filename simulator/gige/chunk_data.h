#pragma once
// Chunk data: what a camera appends to a frame's pixels about it (GigE Vision 2.x, "Image with chunks", payload type
// 0x4001). Each chunk is its data, then its id and its length, so that a reader begins at the end. Pure, big-endian.
#include <chrono>
#include <cstdint>
#include <vector>

#include "capture/frame.h"

namespace rotunda::simulator {

// In the order of ChunkSelector; the id is how GenICam finds the chunk.
enum class Chunk : std::uint32_t { timestamp = 0, exposure_time = 1, line_status_all = 2, frame_id = 3, gain = 4 };
inline constexpr std::uint32_t kChunks = 5;
inline constexpr std::uint32_t kImageChunkId = 0x10000001;
constexpr std::uint32_t chunk_id(Chunk chunk) {
  return 0x10000100 + static_cast<std::uint32_t>(chunk);
}

struct ChunkValues {
  std::uint32_t enabled = 0;  // bit n: chunk n
  capture::Timestamp exposure_start;
  std::chrono::nanoseconds exposure{};
  std::uint32_t line_status = 0;  // bit 0: Line0 when the exposure started
  std::uint64_t frame_id = 0;
  std::uint32_t gain = 0;  // 0.01 dB
};

// What follows `picture_bytes` of pixels: padding to whole words, the image's own id and length, the enabled chunks.
std::vector<std::uint8_t> chunk_data(std::size_t picture_bytes, const ChunkValues& values);
std::size_t chunk_data_bytes(std::size_t picture_bytes, std::uint32_t enabled);

}  // namespace rotunda::simulator
