#include "simulator/gige/region.h"

#include <gtest/gtest.h>

namespace rotunda::simulator {
namespace {

using Bytes = std::vector<std::uint8_t>;

}  // namespace

TEST(Region, ReadsItsRowsOutOfThePicture) {
  const Bytes picture{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};  // 4 x 3
  EXPECT_EQ(read_out(picture, 4, 8, {.width = 2, .height = 2, .offset_x = 1, .offset_y = 1}), (Bytes{5, 6, 9, 10}));
  EXPECT_EQ(read_out(picture, 4, 8, {.width = 4, .height = 3}), picture);
}

TEST(Region, TakesWholeBytesOfPackedPixels) {
  const Bytes picture{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};  // 4 x 2 of 12 bits
  EXPECT_EQ(read_out(picture, 4, 12, {.width = 2, .height = 2, .offset_x = 2}), (Bytes{3, 4, 5, 9, 10, 11}));
}

}  // namespace rotunda::simulator
