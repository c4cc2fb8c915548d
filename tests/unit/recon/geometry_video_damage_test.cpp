#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "config/errors.h"
#include "recon/video/geometry_video.h"
#include "tests/unit/recon/geometry_video_files.h"

namespace rotunda::recon {
namespace {

using test::bytes_of;
using test::largest_distance;
using test::put_bytes;
using test::travelling_ball;
using test::write;
using ::testing::HasSubstr;

using GeometryVideoDamage = test::GeometryVideoTest;

TEST_F(GeometryVideoDamage, CutShortKeepsTheFramesBeforeTheCut) {
  const auto images = travelling_ball(10, 4);
  write_geometry_video(file_, images);
  const std::string whole = bytes_of(file_);
  put_bytes(file_, whole.substr(0, whole.size() * 6 / 10));
  GeometryVideoReader reader(file_);
  EXPECT_EQ(reader.frame_count(), 10);
  for (int i = 0; i < 5; ++i) EXPECT_LT(largest_distance(reader.read(i), images[static_cast<std::size_t>(i)]), 2e-5F);
  try {
    reader.read(9);
    ADD_FAILURE() << "a frame that is not there was read";
  } catch (const CorruptData& error) {
    EXPECT_THAT(error.what(), HasSubstr(file_.string()));
    EXPECT_THAT(error.what(), HasSubstr("cut short"));
  }
  EXPECT_LT(largest_distance(reader.read(2), images[2]), 2e-5F);  // the reader goes on after it
}

// Whatever is cut off or flipped: either the pixels are right, or CorruptData. (The header is text without a checksum.)
void expect_no_wrong_pixels(const std::filesystem::path& file, const std::vector<GeometryImage>& images) {
  const std::string whole = bytes_of(file);
  int refused = 0, right = 0;
  const auto try_read = [&](const std::string& bytes) {
    put_bytes(file, bytes);
    try {
      GeometryVideoReader reader(file);
      for (int i = 0; i < reader.frame_count() && i < 3; ++i) {
        const GeometryImage image = reader.read_in_place(i, reader.header().level);
        ++right;
        ASSERT_EQ(image.colours, images[static_cast<std::size_t>(i)].colours);
      }
    } catch (const CorruptData&) {
      ++refused;
    }
  };
  for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 150)
    try_read(whole.substr(0, length));
  std::mt19937 random(7);
  for (int i = 0; i < 150; ++i) {
    std::string flipped = whole;
    char& byte = flipped[random() % whole.size()];
    byte = static_cast<char>(byte ^ (1 << (random() % 8)));
    try_read(flipped);
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(right, 100);
}

TEST_F(GeometryVideoDamage, NeverGivesWrongPixelsInSilence) {
  const auto images = travelling_ball(3, 2);
  write_geometry_video(file_, images);
  expect_no_wrong_pixels(file_, images);
}

TEST_F(GeometryVideoDamage, NorDoesAMasterWhoseColourChecksumsStandInTheHeader) {
  const auto images = travelling_ball(3, 5);
  write(file_, images, VideoProfile::master);
  expect_no_wrong_pixels(file_, images);
}

TEST_F(GeometryVideoDamage, OfProfileStreamTellsDamageByItsChecksums) {
  const auto images = travelling_ball(6, 6);
  write(file_, images, VideoProfile::stream);
  std::vector<GeometryImage> whole;
  {
    GeometryVideoReader reader(file_);
    for (int i = 0; i < 6; ++i) whole.push_back(reader.read(i));
  }
  const std::string bytes = bytes_of(file_);
  std::mt19937 random(5);
  int refused = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::string flipped = bytes;
    flipped[bytes.size() / 2 + random() % (bytes.size() / 2)] ^= 0x10;  // behind the header and the mean
    put_bytes(file_, flipped);
    try {
      GeometryVideoReader reader(file_);
      for (int i = 0; i < 6; ++i) {
        const auto image = reader.read(i);
        ASSERT_EQ(image.colours, whole[static_cast<std::size_t>(i)].colours);
        ASSERT_EQ(image.positions, whole[static_cast<std::size_t>(i)].positions);
      }
    } catch (const CorruptData&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 10);
}

TEST_F(GeometryVideoDamage, OtherFilesAreRefusedByName) {
  EXPECT_THROW(GeometryVideoReader(folder_ / "none.mkv"), std::system_error);
  put_bytes(file_, "this is not a video");
  EXPECT_THROW(GeometryVideoReader{file_}, CorruptData);
  put_bytes(file_, "");
  EXPECT_THROW(GeometryVideoReader{file_}, CorruptData);
}

}  // namespace
}  // namespace rotunda::recon
