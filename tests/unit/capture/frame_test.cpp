#include "capture/frame.h"

#include <gtest/gtest.h>

#include "config/errors.h"

namespace rotunda::capture {

TEST(PixelFormat, NamesComeBackAsTheSameFormat) {
  for (const auto format : {PixelFormat::mono8, PixelFormat::bayer_rg8, PixelFormat::bayer_bg8, PixelFormat::rgb8,
                            PixelFormat::bayer_rg12p})
    EXPECT_EQ(pixel_format_from(to_string(format)), format);
  EXPECT_FALSE(pixel_format_from("Mono12Packed"));
}

TEST(MakeImage, RefusesFewerBytesThanTheSizeAsksFor) {
  EXPECT_THROW(make_image(4, 4, PixelFormat::rgb8, std::vector<std::uint8_t>(47)), InvalidInput);
  EXPECT_EQ(make_image(4, 4, PixelFormat::rgb8, std::vector<std::uint8_t>(48)).bytes().size(), 48U);
}

TEST(FrameSet, IsCompleteOnlyWithoutHoles) {
  FrameSet set;
  set.slots.resize(2);
  set.slots[0].frame = Frame{};
  EXPECT_FALSE(set.complete());
  set.slots[1].frame = Frame{};
  EXPECT_TRUE(set.complete());
}

}  // namespace rotunda::capture
