#include "rig/tui/page_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rotunda::rig {
namespace {

using ::testing::HasSubstr;
using Kind = PageRequest::Kind;

PageState page(const std::string& state = "armed") {
  PageState page;
  page.status = RigStatus{.rig = "studio", .state = state};
  return page;
}

PageState page_with_take(const std::string& state = "armed") {
  auto with = page(state);
  with.status->take.name = "take001";
  with.status->take.closed = state != "recording";
  return with;
}

void type(PageState& state, const std::u32string& keys) {
  for (const char32_t key : keys) EXPECT_FALSE(press(state, key));
}

TEST(PageKeys, ArmAndDisarmByOneKey) {
  auto armed = page(), live = page("live");
  EXPECT_EQ(press(armed, 'a')->kind, Kind::arm);
  EXPECT_EQ(press(live, 'a')->kind, Kind::disarm);
}

TEST(PageKeys, RecordUsesTheSlateThatWasTyped) {
  auto state = page();
  type(state, U"l12");
  type(state, U"\n");
  EXPECT_EQ(state.prompt, Prompt::shot);
  type(state, U"Bx\x7f\n");
  const auto request = press(state, 'r');
  ASSERT_TRUE(request);
  EXPECT_EQ(request->kind, Kind::record);
  EXPECT_EQ(request->scene, "12");
  EXPECT_EQ(request->shot, "B");
}

TEST(PageKeys, SayWhyTheyDoNothing) {
  auto idle = page(), recording = page_with_take("recording");
  for (const char32_t key : {U's', U'm', U'n', U'c'}) {
    idle.message.clear();
    EXPECT_FALSE(press(idle, key));
    EXPECT_NE(idle.message, "") << static_cast<char>(key);
  }
  EXPECT_FALSE(press(recording, 'r'));
  EXPECT_THAT(recording.message, HasSubstr("take001 is recording"));
  EXPECT_EQ(press(recording, 's')->kind, Kind::stop);
  EXPECT_EQ(press(recording, 'm')->kind, Kind::mark);
}

TEST(PageKeys, TypingANoteIsNoCommand) {
  auto state = page_with_take("recording");
  type(state, U"nqsr s\u00e9");
  EXPECT_FALSE(state.quit);
  const auto request = press(state, kKeyEnter);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->kind, Kind::note);
  EXPECT_EQ(request->text, "qsr sé");
  type(state, U"nlost");
  EXPECT_FALSE(press(state, kKeyEscape));
  EXPECT_EQ(state.prompt, Prompt::none);
  EXPECT_FALSE(state.quit);
}

TEST(PageKeys, CircleTurnsRoundWhatIsSo) {
  auto state = page_with_take();
  EXPECT_TRUE(press(state, 'c')->on);
  state.status->take.circled = true;
  EXPECT_FALSE(press(state, 'c')->on);
}

TEST(PageKeys, TheTakeListChoosesPlaysAndComesBack) {
  auto state = page();
  EXPECT_EQ(press(state, 't')->kind, Kind::list_takes);
  EXPECT_FALSE(press(state, kKeyEnter)) << "there is none to play";
  state.takes = {{.name = "a"}, {.name = "b", .circled = true}};
  type(state, {kKeyUp, kKeyDown, kKeyDown});
  EXPECT_EQ(state.selected, 1U);
  EXPECT_EQ(press(state, kKeyEnter)->take.name, "b");
  const auto circle = press(state, 'c');
  EXPECT_EQ(circle->kind, Kind::circle_take);
  EXPECT_FALSE(circle->on);
  type(state, U"nx");
  const auto note = press(state, kKeyEnter);
  EXPECT_EQ(note->kind, Kind::note_take);
  EXPECT_EQ(note->take.name, "b");
  EXPECT_FALSE(press(state, 't'));
  EXPECT_EQ(state.view, View::rig);
}

TEST(PageKeys, QuitAsksNothingOfTheDaemon) {
  for (const char32_t key : {U'q', U'\x03'}) {
    auto state = page_with_take("recording");
    EXPECT_FALSE(press(state, key));
    EXPECT_TRUE(state.quit);
  }
}

TEST(PageKeys, HelpOpensAndCloses) {
  auto state = page();
  type(state, U"?");
  EXPECT_EQ(state.view, View::help);
  type(state, U"r");
  EXPECT_EQ(state.view, View::help) << "keys do nothing behind the help";
  type(state, U"?");
  EXPECT_EQ(state.view, View::rig);
}

}  // namespace
}  // namespace rotunda::rig
