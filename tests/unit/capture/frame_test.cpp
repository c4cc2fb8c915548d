#include "capture/frame.h"

#include <gtest/gtest.h>

#include "config/errors.h"

namespace rotunda::capture {

TEST(PixelFormat, NamesComeBackAsTheSameFormat) {
  EXPECT_EQ(pixel_formats().size(), static_cast<std::size_t>(PixelFormat::mjpeg) + 1);
  for (const auto format : pixel_formats()) EXPECT_EQ(pixel_format_from(to_string(format)), format);
  EXPECT_FALSE(pixel_format_from("Mono12Packed"));
  for (const auto coding :
       {YcbcrCoding::bt601_limited, YcbcrCoding::bt601_full, YcbcrCoding::bt709_limited, YcbcrCoding::bt709_full})
    EXPECT_EQ(ycbcr_coding_from(to_string(coding)), coding);
  EXPECT_FALSE(ycbcr_coding_from("bt2020"));
}

TEST(PixelFormat, AnImageHasAsManyBytesAsItsPackingNeeds) {
  EXPECT_EQ(image_bytes(8, 4, PixelFormat::bayer_gb8), 32U);
  EXPECT_EQ(image_bytes(8, 4, PixelFormat::bayer_gb10), 64U);
  EXPECT_EQ(image_bytes(8, 4, PixelFormat::bayer_gb10_csi2p), 40U);
  EXPECT_EQ(image_bytes(8, 4, PixelFormat::bayer_gb12_csi2p), 48U);
  EXPECT_EQ(image_bytes(3, 1, PixelFormat::bayer_rg12p), 5U);
  EXPECT_EQ(image_bytes(8, 4, PixelFormat::uyvy), 64U);
  EXPECT_EQ(image_bytes(8, 4, PixelFormat::nv12), 48U);
  EXPECT_EQ(make_image(8, 4, PixelFormat::mjpeg, std::vector<std::uint8_t>(77)).size_bytes(), 77U);
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
