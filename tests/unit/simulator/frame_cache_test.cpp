#include "simulator/studio/frame_cache.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"

namespace rotunda::simulator {
namespace {

namespace fs = std::filesystem;
using capture::PixelFormat;

class FrameCacheTest : public testing::Test {
 protected:
  FrameCacheTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~FrameCacheTest() override { fs::remove_all(folder_); }

  FrameCache cache(std::uint64_t most_bytes = 1'000'000) const {
    return FrameCache({.folder = folder_, .most_bytes = most_bytes});
  }
  static PictureKey key(const std::string& performance) {
    return picture_key(performance, camera_layout({.cameras = 2}), {}, PixelFormat::mono8);
  }
  static EntryShape shape() { return {.frames = 4, .picture_bytes = {1000, 500}}; }
  static PictureSet pictures(int frame) {
    return {std::vector<std::uint8_t>(1000, static_cast<std::uint8_t>(frame)),
            std::vector<std::uint8_t>(500, static_cast<std::uint8_t>(frame + 100))};
  }
  static void fill(CacheEntry& entry) {
    for (int frame = 0; frame < entry.shape().frames; ++frame) entry.write(frame, pictures(frame));
  }
  fs::path file(const PictureKey& k, const std::string& name) const { return folder_ / k.digest / name; }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("frame_cache_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(FrameCacheTest, GivesBackWhatWasWritten) {
  EXPECT_FALSE(cache().find(key("walk")));
  {
    auto entry = cache().open(key("walk"), shape());
    EXPECT_EQ(entry.missing(), (std::vector<int>{0, 1, 2, 3}));
    entry.write(2, pictures(2));  // interrupted after one
  }
  const auto entry = cache().find(key("walk"));
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->shape().picture_bytes, shape().picture_bytes);
  EXPECT_EQ(entry->missing(), (std::vector<int>{0, 1, 3}));
  EXPECT_EQ(entry->read(2), pictures(2));
  EXPECT_FALSE(entry->read(1));
  std::vector<std::uint8_t> second(500);
  EXPECT_TRUE(entry->read(2, 1, second));
  EXPECT_EQ(second, pictures(2)[1]);
}

TEST_F(FrameCacheTest, EverythingThatDeterminesPixelsIsInTheKey) {
  const auto cameras = camera_layout({.cameras = 3});
  const auto plain = picture_key("p", cameras, {}, PixelFormat::mono8).digest;
  EXPECT_EQ(picture_key("p", cameras, {}, PixelFormat::mono8).digest, plain);
  EXPECT_NE(picture_key("q", cameras, {}, PixelFormat::mono8).digest, plain);
  EXPECT_NE(picture_key("p", cameras, {}, PixelFormat::rgb8).digest, plain);
  auto moved = cameras;
  moved[2].distortion[3] = 1e-9;
  EXPECT_NE(picture_key("p", moved, {}, PixelFormat::mono8).digest, plain);
  SensorOptions noisy;
  noisy.seed = 2;
  SensorOptions colourful;
  colourful.lateral_colour_px = 1.0;
  EXPECT_NE(picture_key("p", cameras, colourful, PixelFormat::mono8).digest, plain);
  EXPECT_NE(picture_key("p", cameras, {}, PixelFormat::mono8, {.wear = 2.0}).digest, plain);
  EXPECT_NE(picture_key("p", cameras, noisy, PixelFormat::mono8).digest, plain);
  EXPECT_TRUE(fingerprint_of({}));
  EXPECT_NE(fingerprint_of({.act = "idle"}), fingerprint_of({.act = "walk"}));
  EXPECT_FALSE(fingerprint_of({.person = "somebody.glb"}));
}

TEST_F(FrameCacheTest, WhatIsDamagedIsGoneAndCanBeWrittenAgain) {
  auto entry = cache().open(key("walk"), shape());
  fill(entry);
  {
    std::fstream flipped(file(key("walk"), "frame000001.pictures"), std::ios::in | std::ios::out | std::ios::binary);
    flipped.seekp(700);
    flipped.put('x');
  }
  fs::resize_file(file(key("walk"), "frame000003.pictures"), 1200);
  EXPECT_EQ(entry.missing(), std::vector<int>{3});  // too short: seen without reading
  EXPECT_FALSE(entry.read(1));
  EXPECT_EQ(entry.missing(), (std::vector<int>{1, 3}));
  EXPECT_FALSE(entry.read());
  entry.write(1, pictures(1));
  entry.write(3, pictures(3));
  EXPECT_EQ(entry.read()->at(3), pictures(3));
  std::ofstream(file(key("walk"), "entry.json")) << "{\"frames\": 4";
  EXPECT_FALSE(cache().find(key("walk")));
  EXPECT_TRUE(cache().open(key("walk"), shape()).missing().empty());  // the frames themselves are good
}

TEST_F(FrameCacheTest, TheEntryUnusedForLongestMakesRoom) {
  for (const char* name : {"a", "b"}) {
    auto entry = cache().open(key(name), shape());
    fill(entry);
  }
  const auto now = fs::file_time_type::clock::now();
  fs::last_write_time(file(key("a"), "lock"), now - std::chrono::hours(1));
  fs::last_write_time(file(key("b"), "lock"), now - std::chrono::hours(2));
  EXPECT_TRUE(cache().find(key("b")));  // used: a is the oldest now
  const auto kept = cache().bytes();
  auto small = cache(kept + shape().bytes() / 2);
  auto entry = small.open(key("c"), shape());
  EXPECT_FALSE(small.find(key("a")));
  EXPECT_TRUE(small.find(key("b")));
  EXPECT_THROW(cache(1000).open(key("d"), shape()), InvalidInput);
}

TEST_F(FrameCacheTest, NobodyRemovesWhatIsInUse) {
  auto used = cache().open(key("used"), shape());
  fill(used);
  fs::last_write_time(file(key("used"), "lock"), fs::file_time_type::clock::now() - std::chrono::hours(9));
  auto other = cache(shape().bytes()).open(key("other"), shape());
  EXPECT_EQ(used.read(0), pictures(0));
}

TEST_F(FrameCacheTest, SeveralMayWriteTheSameAtOnce) {
  {
    std::vector<std::jthread> writers;
    for (int i = 0; i < 4; ++i)
      writers.emplace_back([this] {
        auto entry = cache().open(key("walk"), shape());
        fill(entry);
      });
  }
  const auto frames = cache().find(key("walk"))->read();
  ASSERT_TRUE(frames);
  for (int frame = 0; frame < 4; ++frame) EXPECT_EQ(frames->at(static_cast<std::size_t>(frame)), pictures(frame));
}

TEST_F(FrameCacheTest, RefusesPicturesOfAnotherShape) {
  auto entry = cache().open(key("walk"), shape());
  EXPECT_THROW(entry.write(4, pictures(0)), InvalidInput);
  EXPECT_THROW(entry.write(0, {pictures(0)[0]}), InvalidInput);
}

}  // namespace
}  // namespace rotunda::simulator
