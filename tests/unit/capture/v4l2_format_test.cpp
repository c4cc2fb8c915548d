#include "capture/source/v4l2_format.h"

#include <gtest/gtest.h>

namespace rotunda::capture {
namespace {

TEST(V4l2Format, EveryFormatThatV4l2HasComesBackAsItself) {
  int known = 0;
  for (const auto format : pixel_formats())
    for (const auto fourcc : fourccs_of(format)) {
      EXPECT_EQ(pixel_format_of(fourcc), format) << fourcc_text(fourcc);
      ++known;
    }
  EXPECT_EQ(known, 27);
  EXPECT_TRUE(fourccs_of(PixelFormat::bayer_rg12p).empty());  // GenICam's own packing
  EXPECT_FALSE(pixel_format_of(V4L2_PIX_FMT_H264));
  EXPECT_EQ(fourcc_text(V4L2_PIX_FMT_SRGGB10P), "pRAA");
}

TEST(V4l2Format, ColorimetryFollowsTheKernelsDefaults) {
  const auto coding = [](std::uint32_t space, std::uint32_t encoding, std::uint32_t range) {
    return colorimetry_of(space, encoding, range).coding;
  };
  EXPECT_EQ(coding(V4L2_COLORSPACE_SRGB, 0, 0), YcbcrCoding::bt601_limited);
  EXPECT_EQ(coding(V4L2_COLORSPACE_SMPTE170M, 0, 0), YcbcrCoding::bt601_limited);
  EXPECT_EQ(coding(V4L2_COLORSPACE_REC709, 0, 0), YcbcrCoding::bt709_limited);
  EXPECT_EQ(coding(V4L2_COLORSPACE_JPEG, 0, 0), YcbcrCoding::bt601_full);
  EXPECT_EQ(coding(V4L2_COLORSPACE_SRGB, V4L2_YCBCR_ENC_709, V4L2_QUANTIZATION_FULL_RANGE), YcbcrCoding::bt709_full);
  EXPECT_EQ(coding(V4L2_COLORSPACE_REC709, V4L2_YCBCR_ENC_XV601, V4L2_QUANTIZATION_LIM_RANGE),
            YcbcrCoding::bt601_limited);
  EXPECT_TRUE(colorimetry_of(V4L2_COLORSPACE_REC709, 0, 0).exact);
  EXPECT_FALSE(colorimetry_of(V4L2_COLORSPACE_BT2020, 0, 0).exact);
}

}  // namespace
}  // namespace rotunda::capture
