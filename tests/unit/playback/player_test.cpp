#include "playback/player.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "config/errors.h"
#include "playback/display/headless.h"
#include "playback/frame_fetcher.h"
#include "tests/support/virtual_screen.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::playback {
namespace {

class Player : public ::testing::Test {
 protected:
  Player() {
    std::filesystem::create_directories(folder_);
    std::vector<recon::GeometryImage> images;
    for (int i = 0; i < 10; ++i)
      images.push_back(test::round_geometry_image({.level = 4, .centre = {0.1F * static_cast<float>(i), 0.0F, 1.0F}}));
    recon::write_geometry_video(file_, images);
  }
  ~Player() override { std::filesystem::remove_all(folder_); }

  // Mesa's driver stays loaded with it: what only the driver points to would else look leaked once GLFW unloads it.
  const HeadlessDisplay driver_;
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("rotunda_player_" + std::to_string(::getpid()));
  std::filesystem::path file_ = folder_ / "geometry.mkv";
};

TEST_F(Player, PlaysInAWindowUntilItsLimit) {
  const tests::VirtualScreen screen;
  ::setenv("DISPLAY", screen.display().c_str(), 1);
  recon::GeometryVideoReader video(file_);
  const PlayReport report = play(video, {.width = 320, .height = 240, .picture_limit = 40});
  EXPECT_EQ(report.pictures, 40);
  EXPECT_GT(report.frames, 5);  // 40 pictures last two thirds of a second at the least: 16 frames at 25 a second
  EXPECT_GT(report.seconds, 0.66);
  ::unsetenv("DISPLAY");
}

TEST_F(Player, StopsWhenAsked) {
  const tests::VirtualScreen screen;
  ::setenv("DISPLAY", screen.display().c_str(), 1);
  recon::GeometryVideoReader video(file_);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(play(video, {.width = 64, .height = 64, .stop = stop.get_token()}).pictures, 0);
  ::unsetenv("DISPLAY");
}

TEST_F(Player, SaysThatThereIsNoDisplay) {
  ::unsetenv("DISPLAY");
  recon::GeometryVideoReader video(file_);
  try {
    play(video);
    ADD_FAILURE() << "played without a display";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("no display"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("rotunda render"));
  }
}

TEST_F(Player, FetcherGivesEveryFrameInAnyOrder) {
  recon::GeometryVideoReader video(file_), again(file_);
  for (const std::size_t memory : {std::size_t{1}, std::size_t{1} << 30}) {  // a ring of four, and all
    FrameFetcher fetcher(video, {.memory = memory});
    for (const int frame : {0, 1, 2, 9, 0, 5, 4, 3, 3, 8, 9, 0, 1})
      EXPECT_EQ(fetcher.wait_for(frame)->positions, again.read(frame).positions) << frame;
  }
}

TEST_F(Player, FetcherTellsOfADamagedFrameWhenItIsWanted) {
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) / 2);
  recon::GeometryVideoReader video(file_);
  FrameFetcher fetcher(video);
  EXPECT_NE(fetcher.wait_for(1), nullptr);
  EXPECT_THROW(fetcher.wait_for(9), CorruptData);
  EXPECT_NE(fetcher.wait_for(2), nullptr);
}

}  // namespace
}  // namespace rotunda::playback
