#include "recon/live_surface.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "capture/base/crc32c.h"
#include "config/errors.h"
#include "tests/support/closed_shapes.h"

namespace rotunda::recon {
namespace {

LiveSurface ball() {
  LiveSurface surface{.trigger = 77,
                      .exposure = capture::Timestamp(std::chrono::nanoseconds(1'700'000'000'123'456'789)),
                      .made = capture::Timestamp(std::chrono::nanoseconds(1'700'000'000'223'456'789)),
                      .mesh = tests::icosphere(3)};
  for (std::size_t v = 0; v < surface.mesh.positions.size(); ++v)
    surface.mesh.colours.push_back({static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(v / 3), 200});
  return surface;
}

// As a stranger would who knows the check sum.
std::vector<std::uint8_t> with_u32(std::vector<std::uint8_t> bytes, std::size_t offset, std::uint32_t value) {
  std::memcpy(bytes.data() + offset, &value, 4);
  const auto sum = capture::crc32c({bytes.data(), bytes.size() - 4});
  std::memcpy(bytes.data() + bytes.size() - 4, &sum, 4);
  return bytes;
}

TEST(LiveSurface, ArrivesAsItWasSent) {
  const auto sent = ball();
  const auto came = unpack_surface(pack_surface(sent));
  EXPECT_EQ(came.trigger, sent.trigger);
  EXPECT_EQ(came.exposure, sent.exposure);
  EXPECT_EQ(came.made, sent.made);
  EXPECT_EQ(came.mesh.triangles, sent.mesh.triangles);
  EXPECT_EQ(came.mesh.colours, sent.mesh.colours);
  ASSERT_EQ(came.mesh.positions.size(), sent.mesh.positions.size());
  for (std::size_t v = 0; v < came.mesh.positions.size(); ++v)
    EXPECT_LT((came.mesh.positions[v] - sent.mesh.positions[v]).cwiseAbs().maxCoeff(),
              2.0F / 65535)  // half a step, rounded
        << v;
}

TEST(LiveSurface, OfNothingOrOfOnePointArrivesToo) {
  EXPECT_TRUE(unpack_surface(pack_surface({})).mesh.positions.empty());
  const LiveSurface point{.mesh = {.positions = {{1, 2, 3}}, .normals = {}, .colours = {{1, 2, 3}}, .triangles = {}}};
  EXPECT_EQ(unpack_surface(pack_surface(point)).mesh.positions[0], Eigen::Vector3f(1, 2, 3));
}

TEST(LiveSurface, WhatCannotArriveIsNotSent) {
  auto surface = ball();
  surface.mesh.colours.pop_back();
  EXPECT_THROW(pack_surface(surface), InvalidInput);
  surface = ball();
  surface.mesh.positions[3].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(pack_surface(surface), InvalidInput);
  surface = ball();
  surface.mesh.triangles[5][1] = static_cast<std::uint32_t>(surface.mesh.positions.size());
  EXPECT_THROW(pack_surface(surface), InvalidInput);
}

TEST(LiveSurface, EveryTruncationAndEveryFlippedByteIsRefused) {
  LiveSurface small{.mesh = tests::icosphere(0)};
  small.mesh.colours.resize(small.mesh.positions.size());
  const auto whole = pack_surface(small);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(unpack_surface({whole.data(), size}), CorruptData) << size;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto spoilt = whole;
    spoilt[i] ^= 0x40;
    EXPECT_THROW(unpack_surface(spoilt), CorruptData) << i;
  }
}

TEST(LiveSurface, HostileNumbersWithARightCheckSumAreRefused) {
  const auto whole = pack_surface(ball());
  constexpr std::size_t kVertices = 28, kTriangles = 32, kBox = 36;
  for (const std::uint32_t count : {0U, 1U, 0x7fffffffU, 0xffffffffU}) {
    EXPECT_THROW(unpack_surface(with_u32(whole, kVertices, count)), CorruptData) << count;
    EXPECT_THROW(unpack_surface(with_u32(whole, kTriangles, count)), CorruptData) << count;
  }
  constexpr std::uint32_t kNan = 0x7fc00000, kInfinity = 0x7f800000, kHuge = 0x7f7fffff;
  for (const std::uint32_t bits : {kNan, kInfinity, kHuge})
    EXPECT_THROW(unpack_surface(with_u32(whole, kBox, bits)), CorruptData) << bits;
  EXPECT_THROW(unpack_surface(with_u32(whole, whole.size() - 8, 1'000'000)), CorruptData) << "the last triangle";
}

}  // namespace
}  // namespace rotunda::recon
