#include "simulator/gige/chunk_data.h"

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

constexpr std::size_t kTagBytes = 8;  // id and length

template <class Unsigned>
void append(std::vector<std::uint8_t>& bytes, Unsigned value) {
  bytes.resize(bytes.size() + sizeof value);
  store_be(std::span{bytes}, bytes.size() - sizeof value, value);
}

void append_tag(std::vector<std::uint8_t>& bytes, std::uint32_t id, std::size_t length) {
  append(bytes, id);
  append(bytes, static_cast<std::uint32_t>(length));
}

bool is_long(Chunk chunk) {
  return chunk == Chunk::timestamp || chunk == Chunk::frame_id;
}

std::uint64_t value_of(Chunk chunk, const ChunkValues& values) {
  switch (chunk) {
    case Chunk::timestamp:
      return static_cast<std::uint64_t>(values.exposure_start.time_since_epoch().count());
    case Chunk::exposure_time:
      return static_cast<std::uint64_t>(values.exposure.count());
    case Chunk::line_status_all:
      return values.line_status;
    case Chunk::frame_id:
      return values.frame_id;
    case Chunk::gain:
      return values.gain;
  }
  return 0;
}

std::size_t padding(std::size_t picture_bytes) {
  return (4 - picture_bytes % 4) % 4;
}

}  // namespace

std::vector<std::uint8_t> chunk_data(std::size_t picture_bytes, const ChunkValues& values) {
  std::vector<std::uint8_t> bytes(padding(picture_bytes));
  append_tag(bytes, kImageChunkId, picture_bytes + padding(picture_bytes));
  for (std::uint32_t number = 0; number < kChunks; ++number) {
    if ((values.enabled >> number & 1) == 0) continue;
    const auto chunk = static_cast<Chunk>(number);
    const auto value = value_of(chunk, values);
    if (is_long(chunk)) {
      append(bytes, value);
    } else {
      append(bytes, static_cast<std::uint32_t>(value));
    }
    append_tag(bytes, chunk_id(chunk), is_long(chunk) ? 8 : 4);
  }
  return bytes;
}

std::size_t chunk_data_bytes(std::size_t picture_bytes, std::uint32_t enabled) {
  std::size_t bytes = padding(picture_bytes) + kTagBytes;
  for (std::uint32_t number = 0; number < kChunks; ++number)
    if ((enabled >> number & 1) != 0) bytes += kTagBytes + (is_long(static_cast<Chunk>(number)) ? 8 : 4);
  return bytes;
}

}  // namespace rotunda::simulator
