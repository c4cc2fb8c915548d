#include "simulator/gige/chunk_data.h"

#include <gtest/gtest.h>

#include <map>

#include "simulator/gige/big_endian.h"

namespace rotunda::simulator {
namespace {

// As a client reads: from the end.
std::map<std::uint32_t, std::uint32_t> lengths_backwards(std::size_t picture, const std::vector<std::uint8_t>& chunks) {
  std::vector<std::uint8_t> payload(picture);
  payload.insert(payload.end(), chunks.begin(), chunks.end());
  std::map<std::uint32_t, std::uint32_t> lengths;
  for (std::size_t end = payload.size(); end > 0;) {
    const auto length = load_be<std::uint32_t>(std::span<const std::uint8_t>{payload}, end - 4);
    lengths[load_be<std::uint32_t>(std::span<const std::uint8_t>{payload}, end - 8)] = length;
    end -= 8 + length;
  }
  return lengths;
}

}  // namespace

TEST(ChunkData, ReadsBackwardsToThePicture) {
  for (const std::size_t picture : {400U, 401U, 403U}) {
    const auto chunks = chunk_data(picture, {.enabled = 0b11111});
    EXPECT_EQ(chunks.size(), chunk_data_bytes(picture, 0b11111));
    const auto lengths = lengths_backwards(picture, chunks);
    EXPECT_EQ(lengths.size(), 6U);
    EXPECT_EQ(lengths.at(kImageChunkId), (picture + 3) / 4 * 4);
    EXPECT_EQ(lengths.at(chunk_id(Chunk::timestamp)), 8U);
    EXPECT_EQ(lengths.at(chunk_id(Chunk::exposure_time)), 4U);
  }
}

TEST(ChunkData, HoldsOnlyWhatIsEnabled) {
  const auto chunks = chunk_data(8, {.enabled = 0b00010, .exposure = std::chrono::microseconds{5000}});
  EXPECT_EQ(chunks.size(), chunk_data_bytes(8, 0b00010));
  EXPECT_EQ(lengths_backwards(8, chunks).size(), 2U);
  EXPECT_EQ(load_be<std::uint32_t>(std::span<const std::uint8_t>{chunks}, 8), 5'000'000U);
}

}  // namespace rotunda::simulator
