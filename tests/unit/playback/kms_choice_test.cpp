#include "playback/display/kms_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/input-event-codes.h>

#include "playback/display/seat_input.h"

namespace rotunda::playback {
namespace {

using testing::Optional;

drmModeModeInfo mode(std::uint16_t width, std::uint16_t height, std::uint32_t hz, std::uint32_t type = 0,
                     std::uint32_t flags = 0) {
  drmModeModeInfo mode{};
  mode.clock = width * height * hz / 1000;
  mode.hdisplay = mode.htotal = width;
  mode.vdisplay = mode.vtotal = height;
  mode.vrefresh = hz;
  mode.type = type;
  mode.flags = flags;
  return mode;
}

ConnectorFacts connector(std::uint32_t id, const std::string& name, bool connected) {
  ConnectorFacts facts{.id = id, .name = name, .connected = connected};
  if (connected) facts.modes = {mode(1920, 1080, 60)};
  return facts;
}

std::string chosen_name(const std::vector<ConnectorFacts>& connectors, const std::string& wanted = "") {
  const auto chosen = choose_connector(connectors, wanted);
  return chosen ? chosen->name : "none";
}

TEST(ConnectorChoice, TakesTheFirstThatIsConnected) {
  EXPECT_EQ(chosen_name({connector(1, "DP-1", false), connector(2, "HDMI-A-1", true), connector(3, "DP-2", true)}),
            "HDMI-A-1");
}

TEST(ConnectorChoice, TakesNoneThatShowsNoPlainPicture) {
  auto goggles = connector(1, "DP-1", true), unread = connector(2, "DP-2", true);
  goggles.desktop = false;
  unread.modes.clear();
  EXPECT_EQ(chosen_name({goggles, unread}), "none");
  EXPECT_EQ(chosen_name({goggles, unread, connector(3, "DP-3", true)}), "DP-3");
  EXPECT_EQ(chosen_name({}), "none");
}

TEST(ConnectorChoice, TakesTheNamedOneThoughItIsUnplugged) {
  const std::vector both = {connector(1, "DP-1", true), connector(2, "DP-2", false)};
  EXPECT_EQ(chosen_name(both, "DP-2"), "DP-2");
  EXPECT_EQ(chosen_name(both, "DP-3"), "none");
}

std::uint32_t chosen_mode(const std::vector<drmModeModeInfo>& modes) {
  const auto best = choose_mode(modes);
  return best ? best->hdisplay * 10'000U + best->vrefresh : 0;
}

TEST(ModeChoice, TakesWhatTheDisplayPrefers) {
  EXPECT_EQ(chosen_mode({mode(3840, 2160, 30), mode(1920, 1080, 60, DRM_MODE_TYPE_PREFERRED), mode(640, 480, 60)}),
            1920'0060U);
}

TEST(ModeChoice, TakesTheLargestThenTheQuickestWithoutAPreference) {
  EXPECT_EQ(chosen_mode({mode(640, 480, 120), mode(1280, 720, 50), mode(1280, 720, 60)}), 1280'0060U);
  EXPECT_EQ(chosen_mode({}), 0U);
}

TEST(ModeChoice, TakesInterlacedModesLast) {
  EXPECT_EQ(chosen_mode({mode(1920, 1080, 60, DRM_MODE_TYPE_PREFERRED, DRM_MODE_FLAG_INTERLACE), mode(1280, 720, 60)}),
            1280'0060U);
}

TEST(ModeChoice, TellsModesApartByTheirTiming) {
  EXPECT_TRUE(same_mode(mode(640, 480, 60, DRM_MODE_TYPE_PREFERRED), mode(640, 480, 60)));
  EXPECT_FALSE(same_mode(mode(640, 480, 60), mode(640, 480, 75)));
  EXPECT_FALSE(same_mode(mode(640, 480, 60), mode(800, 480, 60)));
}

TEST(CrtcChoice, KeepsTheOneThatFeedsTheConnector) {
  auto screen = connector(1, "DP-1", true);
  screen.crtcs = 0b111;
  screen.crtc = 42;
  EXPECT_THAT(choose_crtc(screen, std::vector{screen}, std::vector<std::uint32_t>{40, 41, 42}), Optional(2));
}

TEST(CrtcChoice, TakesNoneFromAnotherDisplayUnlessItMust) {
  auto screen = connector(1, "DP-1", true), other = connector(2, "DP-2", true);
  screen.crtcs = 0b011;
  other.crtc = 40;
  const std::vector both = {screen, other};
  EXPECT_THAT(choose_crtc(screen, both, std::vector<std::uint32_t>{40, 41, 42}), Optional(1));
  screen.crtcs = 0b001;
  EXPECT_THAT(choose_crtc(screen, both, std::vector<std::uint32_t>{40, 41, 42}), Optional(0));
}

TEST(CrtcChoice, TakesNoneThatCannotFeedTheConnector) {
  auto screen = connector(1, "DP-1", true);
  screen.crtcs = 0b100;
  EXPECT_EQ(choose_crtc(screen, std::vector{screen}, std::vector<std::uint32_t>{40, 41}), std::nullopt);
}

TEST(SeatKeys, MeanWhatTheyMeanInAWindow) {
  EXPECT_THAT(key_of_evdev(KEY_Q), Optional(Key::quit));
  EXPECT_THAT(key_of_evdev(KEY_ESC), Optional(Key::quit));
  EXPECT_THAT(key_of_evdev(KEY_LEFT), Optional(Key::left));
  EXPECT_THAT(key_of_evdev(KEY_KPPLUS), Optional(Key::plus));
  EXPECT_EQ(key_of_evdev(KEY_LEFTSHIFT), std::nullopt);
}

}  // namespace
}  // namespace rotunda::playback
