#include "tests/support/lost_context.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <stop_token>
#include <thread>
#include <utility>

#include "playback/display/headless.h"
#include "playback/display/open_display.h"
#include "playback/live_player.h"
#include "playback/player.h"
#include "recon/sphere/resample.h"
#include "tests/support/virtual_screen.h"
#include "tests/support/window_hand.h"
#include "tests/unit/round_geometry_image.h"

namespace rotunda::playback {
namespace {

using namespace std::chrono_literals;

class LostContext : public ::testing::Test {
 protected:
  LostContext() {
    ::setenv("DISPLAY", screen_.display().c_str(), 1);
    XSetErrorHandler([](::Display*, XErrorEvent*) { return 0; });  // a window may go while it is looked at
  }
  ~LostContext() override {
    tests::lose_contexts(0, 0);
    ::unsetenv("DISPLAY");
    XSetErrorHandler(nullptr);
  }

  // Looks at the window of this title after so many contexts were lost, until its middle is brighter than a room where
  // nothing is drawn, a minute at most; then asks to stop.
  std::jthread watch(const std::string& title, int losses, bool& seen) {
    return std::jthread([this, title, losses, &seen] {
      for (int i = 0; i < 600 && !seen; ++i, std::this_thread::sleep_for(100ms))
        seen = tests::contexts_lost() == losses && brightness_of(title) > 60;
      stop_.request_stop();
    });
  }

  // Of the middle, 0 to 255; 0 if there is no such window now.
  int brightness_of(const std::string& title) {
    try {
      return tests::WindowHand(screen_.display(), title).brightness_at(80, 60);
    } catch (const std::runtime_error&) {
      return 0;
    }
  }

  const HeadlessDisplay driver_;  // as in player_test.cpp
  const tests::VirtualScreen screen_;
  std::stop_source stop_;
};

TEST_F(LostContext, OfATakesWindowIsMadeAnewAndThePlayGoesOn) {
  const auto file = std::filesystem::temp_directory_path() / ("rotunda_lost_" + std::to_string(::getpid()) + ".mkv");
  std::vector<recon::GeometryImage> images(4, test::round_geometry_image({.level = 4, .centre = {0.0F, 0.0F, 1.0F}}));
  recon::write_geometry_video(file, images);
  recon::GeometryVideoReader video(file);
  tests::lose_contexts(2, 5);
  bool seen = false;
  const auto watcher = watch("rotunda", 2, seen);
  const auto report = play(video, {.width = 160, .height = 120, .stop = stop_.get_token()});
  EXPECT_TRUE(seen);
  EXPECT_EQ(report.lost_contexts, 2);
  EXPECT_GT(report.pictures, 8);
  std::filesystem::remove(file);
}

TEST_F(LostContext, OfALiveWindowIsMadeAnewWithWhatWasSeenLast) {
  LiveView view;
  view.surface.mesh = recon::remesh(test::round_geometry_image({.level = 4, .centre = {0.0F, 0.0F, 1.0F}}));
  bool given = false;  // one surface alone: it must be seen again
  tests::lose_contexts(1, 2);
  bool seen = false;
  const auto watcher = watch("rotunda live", 1, seen);
  const auto report = play_live(
      [&]() -> std::optional<LiveView> { return std::exchange(given, true) ? std::nullopt : std::optional(view); },
      {.width = 160, .height = 120, .stop = stop_.get_token()});
  EXPECT_TRUE(seen);
  EXPECT_EQ(report.lost_contexts, 1);
  EXPECT_EQ(report.surfaces, 1);
}

TEST_F(LostContext, AgainAndAgainIsTold) {
  tests::lose_contexts(1000, 1);
  int tried = 0;
  EXPECT_THROW(with_display({.window = {.width = 64, .height = 48}},
                            [&](Display& window) {
                              ++tried;
                              for (;;) window.present();
                            }),
               DeviceError);
  EXPECT_EQ(tried, 10);
}

TEST_F(LostContext, KeepsTheWindowsSize) {
  tests::lose_contexts(1, 1);
  cv::Size last;
  const int lost = with_display({.window = {.width = 200, .height = 100}}, [&](Display& window) {
    last = {window.width(), window.height()};
    window.present();
  });
  EXPECT_EQ(lost, 1);
  EXPECT_EQ(last, cv::Size(200, 100));
}

}  // namespace
}  // namespace rotunda::playback
