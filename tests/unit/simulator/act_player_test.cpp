#include "simulator/studio/act_player.h"

#include <gtest/gtest.h>

#include <deque>
#include <thread>

#include "config/errors.h"
#include "simulator/studio/camera_layout.h"

namespace rotunda::simulator {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int kFrames = 60;
constexpr std::size_t kCameras = 3, kBytes = 4096;

std::vector<std::uint8_t> picture(int frame, std::size_t camera) {
  std::vector<std::uint8_t> bytes(kBytes, static_cast<std::uint8_t>(frame));
  bytes[0] = static_cast<std::uint8_t>(camera);
  return bytes;
}

capture::Timestamp at(std::int64_t step) {
  return capture::Timestamp(40ms * (1'000'000'000 + step));
}
int frame_at(std::int64_t step) {
  return act_frame_at(at(step), kFrames);
}

class ActPlayerTest : public testing::Test {
 protected:
  ActPlayerTest() { fs::remove_all(folder_); }
  ~ActPlayerTest() override { fs::remove_all(folder_); }

  CacheEntry entry() const {
    const auto key = picture_key("counting", camera_layout({.cameras = 3}), {}, capture::PixelFormat::mono8);
    auto made =
        FrameCache({.folder = folder_}).open(key, {.frames = kFrames, .picture_bytes = {kBytes, kBytes, kBytes}});
    for (int frame = 0; frame < kFrames; ++frame)
      if (!made.has(frame)) made.write(frame, {picture(frame, 0), picture(frame, 1), picture(frame, 2)});
    return made;
  }

  // Asks for every camera's picture of these steps and looks at the last eight again each time.
  static void expect_pictures(ActPlayer& player, const std::vector<std::int64_t>& steps,
                              std::chrono::milliseconds pause) {
    struct Lent {
      std::span<const std::uint8_t> pixels;
      int frame;
    };
    std::array<std::deque<Lent>, kCameras> lent;
    for (const auto step : steps) {
      for (std::size_t camera = 0; camera < kCameras; ++camera) {
        auto& of_camera = lent[camera];
        of_camera.push_back({player.picture_at(camera, at(step)), frame_at(step)});
        if (of_camera.size() > 8) of_camera.pop_front();
        for (const auto& [pixels, frame] : of_camera) {
          const auto wanted = picture(frame, camera);
          ASSERT_TRUE(std::equal(pixels.begin(), pixels.end(), wanted.begin(), wanted.end()))
              << "step " << step << " camera " << camera << " frame " << frame;
        }
      }
      std::this_thread::sleep_for(pause);
    }
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("act_player_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

std::vector<std::int64_t> steps(int count, int stride) {
  std::vector<std::int64_t> all;
  for (int i = 0; i < count; ++i) all.push_back(i * stride);
  return all;
}

TEST_F(ActPlayerTest, StreamsTheActRoundAndRoundReadingAhead) {
  const auto player = stream_from_disk(entry());
  EXPECT_EQ(player->frames(), kFrames);
  expect_pictures(*player, steps(2 * kFrames, 1), 3ms);
  const auto counts = player->counts();
  EXPECT_EQ(counts.unexpected, kCameras);  // the first of each
  EXPECT_EQ(counts.damaged, 0U);
  EXPECT_GE(counts.from_disk + counts.unexpected + counts.late, kCameras * kFrames);  // all of it was read
  EXPECT_GT(counts.from_disk, kCameras * kFrames / 2);                                // and most ahead
}

TEST_F(ActPlayerTest, FollowsATriggerOfAnyRateAndItsJumps) {
  const auto player = stream_from_disk(entry());
  auto wild = steps(30, 5);
  for (const std::int64_t step : {1000, 1000, 1001, 990, 991, 992, 2000, 2007, 2014}) wild.push_back(step);
  expect_pictures(*player, wild, 1ms);
  EXPECT_EQ(player->counts().damaged, 0U);
}

TEST_F(ActPlayerTest, GivesTheRightPicturesHoweverFastItIsAsked) {
  const auto player = stream_from_disk(entry());
  expect_pictures(*player, steps(5 * kFrames, 1), 0ms);
}

TEST_F(ActPlayerTest, CamerasMayRunAtDifferentRates) {
  const auto player = stream_from_disk(entry());
  for (std::int64_t step = 0; step < 200; ++step) {
    const auto fast = player->picture_at(0, at(step));
    EXPECT_EQ(fast[1], frame_at(step));
    if (step % 40 == 0) {
      EXPECT_EQ(player->picture_at(1, at(step))[1], frame_at(step));
    }
  }
}

TEST_F(ActPlayerTest, ADamagedPictureIsNotShownAndCounted) {
  const auto player = stream_from_disk(entry());
  for (const auto& item : fs::recursive_directory_iterator(folder_))
    if (item.path().filename() == "frame000030.pictures") fs::resize_file(item.path(), 5000);
  const auto whole = at(kFrames - frame_at(0));  // act frame 0
  EXPECT_EQ(player->picture_at(0, whole).size(), kBytes);
  EXPECT_TRUE(player->picture_at(2, whole + 30 * 40ms).empty());
  EXPECT_EQ(player->counts().damaged, 1U);
  EXPECT_EQ(player->picture_at(2, whole + 31 * 40ms).size(), kBytes);
}

TEST_F(ActPlayerTest, HeldInMemoryItShowsTheSame) {
  const auto player = hold_in_memory(*entry().read());
  EXPECT_EQ(player->frames(), kFrames);
  expect_pictures(*player, steps(70, 1), 0ms);
  EXPECT_THROW(hold_in_memory({}), InvalidInput);
}

}  // namespace
}  // namespace rotunda::simulator
