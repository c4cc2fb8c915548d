// Samples of 10 and 12 bits, packed and not.
#include "capture/packed_samples.h"

#include <gtest/gtest.h>

#include <numeric>

#include "config/errors.h"
#include "take_fixture.h"

namespace rotunda::capture {
namespace {

using Samples = std::vector<std::uint16_t>;
using Bytes = std::vector<std::uint8_t>;

TEST(PackedSamples, LieWhereTheStandardsPutThem) {
  const Samples twelve{0xABC, 0x123};
  EXPECT_EQ(pack_samples(twelve, PixelPacking::pfnc_12p), (Bytes{0xBC, 0x3A, 0x12}));
  EXPECT_EQ(pack_samples(twelve, PixelPacking::csi2_12p), (Bytes{0xAB, 0x12, 0x3C}));
  EXPECT_EQ(pack_samples(twelve, PixelPacking::words), (Bytes{0xBC, 0x0A, 0x23, 0x01}));
  const Samples ten{0x3FD, 0x000, 0x2AA, 0x003};
  EXPECT_EQ(pack_samples(ten, PixelPacking::csi2_10p), (Bytes{0xFF, 0x00, 0xAA, 0x00, 0b11'10'00'01}));
}

// All bytes are some samples, so that whatever a camera sent comes back.
TEST(PackedSamples, ComeBackFromAnyBytes) {
  for (const auto format : {PixelFormat::bayer_rg12p, PixelFormat::bayer_gb10, PixelFormat::bayer_bg10_csi2p,
                            PixelFormat::bayer_gr12_csi2p}) {
    const auto camera = test::cameras_of(1, 12, 10, format)[0];
    const auto image = test::noise_image(camera, 7);
    const auto packing = layout_of(format).packing;
    const auto samples = unpack_samples(image.bytes(), 120, packing);
    const Bytes again = pack_samples(samples, packing);
    EXPECT_TRUE(std::equal(again.begin(), again.end(), image.bytes().begin(), image.bytes().end()))
        << to_string(format);
  }
}

TEST(PackedSamples, OfAnOddNumberNeedNoByteForTheMissingOne) {
  const Bytes bytes{0xBC, 0x3A, 0x12, 0xFE, 0x0D};
  EXPECT_EQ(unpack_samples(bytes, 3, PixelPacking::pfnc_12p), (Samples{0xABC, 0x123, 0xDFE}));
  EXPECT_THROW(pack_samples(Samples{1, 2, 3}, PixelPacking::pfnc_12p), InvalidInput);
}

TEST(PackedSamples, RefuseTooFewBytesAndSamplesOfOneByte) {
  const Bytes bytes(8);
  EXPECT_THROW(unpack_samples(bytes, 6, PixelPacking::pfnc_12p), InvalidInput);
  EXPECT_THROW(unpack_samples(bytes, 5, PixelPacking::words), InvalidInput);
  EXPECT_THROW(unpack_samples(bytes, 8, PixelPacking::bytes), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
