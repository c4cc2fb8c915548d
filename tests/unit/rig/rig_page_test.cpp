#include "rig/tui/rig_page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rig/tui/camera_rows.h"
#include "rig/tui/take_page.h"

namespace rotunda::rig {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr PageSize kSmall{80, 24}, kLarge{160, 50};

CameraStatus camera(int number) {
  CameraStatus camera;
  camera.name = fmt::format("cam{:02}", number);
  camera.device = fmt::format("10.0.0.{}", number + 10);
  camera.state = "streaming";
  camera.rate_hz = 25.0;
  camera.frames = 1234;
  camera.clipped = 0.001;
  camera.focus = 0.5;
  camera.offset_us = 12.34;
  camera.drift_ppm = -0.5;
  return camera;
}

PageState studio(int cameras = 10) {
  RigStatus status{.rig = "studio", .state = "live", .trigger = "action", .rate_hz = 25.0};
  status.disk_free_bytes = 500'000'000'000;
  status.seconds_left = 4321.0;
  status.spread_median_us = 11.0;
  status.spread_p99_us = 42.0;
  for (int i = 0; i < cameras; ++i) status.cameras.push_back(camera(i));
  PageState state;
  take_status(state, status);
  return state;
}

PageState recording_studio() {
  auto state = studio();
  auto& status = *state.status;
  status.state = "recording";
  status.take.name = "12B-03";
  status.take.slate = "12 B 3";
  status.take.frame_sets = 310;
  status.take.complete = 308;
  status.take.marks = 2;
  return state;
}

std::string text_of(const std::vector<Line>& page) {
  std::string text;
  for (const auto& line : page) text += text_of(line) + "\n";
  return text;
}

const Line& line_with(const std::vector<Line>& page, const std::string& word) {
  for (const auto& line : page)
    if (text_of(line).find(word) != std::string::npos) return line;
  throw std::runtime_error("no line says " + word + ":\n" + text_of(page));
}

bool has_style(const Line& line, Style style) {
  for (const auto& span : line)
    if (span.style == style) return true;
  return false;
}

TEST(RigPage, FillsAnySizeWithoutALineTooMany) {
  auto state = recording_studio();
  state.status->cameras[3].state = "lost";
  state.status->warnings.assign(
      30, "something that takes more than a line of any terminal that is eighty columns wide, twice");
  for (const PageSize size : {PageSize{1, 1}, {40, 10}, {60, 20}, kSmall, {100, 30}, {133, 43}, kLarge}) {
    for (const auto view : {View::rig, View::takes, View::help}) {
      state.view = view;
      const auto page = lay_out(state, size);
      ASSERT_EQ(page.size(), static_cast<std::size_t>(size.rows));
      for (const auto& line : page) EXPECT_LE(width_of(line), size.columns) << text_of(line);
    }
  }
}

TEST(RigPage, TellsTheRecordingTakeAtEightyColumns) {
  const auto page = lay_out(recording_studio(), kSmall);
  EXPECT_EQ(text_of(page[0]), " RECORDING   take 12B-03  00:12  310 frame sets, 308 whole, 2 marks  studio");
  EXPECT_TRUE(has_style(page[0], Style::recording));
  EXPECT_EQ(text_of(page[1]), "trigger action 25 Hz  disk 1:12:01 left (4321 s)  in step 11 us (99% 42)");
  EXPECT_EQ(text_of(page[2]), "slate: scene - shot -  (now 12 B 3)");
  EXPECT_EQ(text_of(page[3]), "camera   state        Hz drops                       clock us clip% focus, peak ");
  EXPECT_EQ(text_of(page[4]), "cam00    streaming  25.0 -                              +12.3   0.1  50 ===|    ");
  EXPECT_THAT(text_of(page[13]), StartsWith("cam09 "));
  EXPECT_THAT(text_of(page[23]), AllOf(HasSubstr("r record"), HasSubstr("s stop"), HasSubstr("q quit")));
}

TEST(RigPage, TellsHowManySurfacesAreMadeAndWhyNone) {
  auto state = recording_studio();
  auto& surfaces = state.status->surfaces;
  surfaces = {.state = "running", .rate_hz = 12.43, .delay_ms = 180.2, .made = 400, .shed = 37};
  EXPECT_THAT(text_of(lay_out(state, kSmall)[2]), HasSubstr("12.4 surfaces/s, 180 ms late, 37 shed"));
  surfaces.rate_hz = 0.0;
  surfaces.problem = "the rig has no calibration";
  const auto page = lay_out(state, kSmall);
  EXPECT_TRUE(has_style(page[2], Style::warn));
  EXPECT_TRUE(has_style(line_with(page, "live surfaces: the rig has no calibration"), Style::warn));
}

TEST(RigPage, TellsTheEngineerMoreWhereThereIsRoom) {
  auto state = recording_studio();
  state.status->cameras[0].clock = "ptp slave";
  state.status->cameras[0].temperature_c = 41.6;
  const auto page = lay_out(state, kLarge);
  EXPECT_THAT(text_of(page[4]), HasSubstr(" ptp slave    42 "));
  const auto head = text_of(page[3]);
  for (const auto* word : {"device", "frames", "resends", "ppm"}) EXPECT_THAT(head, HasSubstr(word));
  EXPECT_THAT(text_of(page[4]), AllOf(HasSubstr("10.0.0.10"), HasSubstr("1234"), HasSubstr("-0.50")));
  EXPECT_EQ(width_of(page[4]), 160);
}

TEST(RigPage, ShowsALostCameraInRedAndInWords) {
  auto state = recording_studio();
  state.status->cameras[3].state = "lost";
  state.status->cameras[3].problem = "cam03: no longer answers; check its cable and power";
  state.status->cameras[7].silent_s = 0.4;  // its state still says streaming
  state.status->cameras[8].silent_s = 0.1;  // two and a half periods: may yet come
  for (const auto size : {kSmall, kLarge}) {
    const auto page = lay_out(state, size);
    for (const auto* name : {"cam03 ", "cam07 "}) {
      EXPECT_TRUE(has_style(line_with(page, name), Style::alarm)) << name;
      EXPECT_THAT(text_of(line_with(page, name)), HasSubstr(" lost "));
    }
    EXPECT_FALSE(has_style(line_with(page, "cam08 "), Style::alarm));
    EXPECT_THAT(text_of(page), HasSubstr("cam03: no longer answers; check its cable and power"));
    EXPECT_THAT(text_of(page), HasSubstr("cam07: no frame for 0.4 s"));
  }
}

TEST(RigPage, TellsDropsByTheirCauseShortWhereItIsNarrow) {
  EXPECT_EQ(drops_by_cause({}, 20), "-");
  EXPECT_EQ(drops_by_cause({{"late", 0}}, 20), "-");
  EXPECT_EQ(drops_by_cause({{"late", 3}, {"packets lost", 1}}, 40), "3 late, 1 packets lost");
  EXPECT_EQ(drops_by_cause({{"late", 3}, {"packets lost", 1}}, 18), "4: late 3 wire 1");
}

TEST(RigPage, HelpsWithinTheSmallestPage) {
  EXPECT_LE(help_view().size(), 22U);
  for (const auto& line : help_view()) EXPECT_LE(width_of(line), 80) << text_of(line);
}

TEST(RigPage, KeepsTheSelectedTakeInSight) {
  auto state = studio();
  state.view = View::takes;
  for (int i = 0; i < 100; ++i) state.takes.push_back({.name = fmt::format("take{:03}", i), .state = "complete"});
  for (const std::size_t selected : {0U, 19U, 20U, 57U, 99U}) {
    state.selected = selected;
    EXPECT_TRUE(has_style(line_with(lay_out(state, kSmall), state.takes[selected].name), Style::selected)) << selected;
  }
}

TEST(RigPage, KeepsTheFocusPeakUntilItIsForgotten) {
  EXPECT_EQ(focus_bar(0.5, 0.5, 8), "===|    ");
  EXPECT_EQ(focus_bar(0.25, 1.0, 8), "==     |");
  EXPECT_EQ(focus_bar(0.0, 0.0, 4), "    ");
  auto state = studio(1);
  auto status = *state.status;
  for (const double score : {0.9, 0.3}) {
    status.cameras[0].focus = score;
    take_status(state, status);
  }
  EXPECT_EQ(state.peak["cam00"], 0.9);
  EXPECT_THAT(text_of(line_with(lay_out(state, kSmall), "cam00")), HasSubstr("30 ==    | "));
}

TEST(RigPage, SaysThatTheDaemonIsGoneAndDimsWhatIsOld) {
  auto state = recording_studio();
  state.trouble = "rotundad: no daemon answers on /run/rotunda.sock; start it with: rotundad --rig RIG";
  const auto page = lay_out(state, kSmall);
  EXPECT_THAT(text_of(page[0]), StartsWith(" NO DAEMON "));
  EXPECT_THAT(text_of(page), AllOf(HasSubstr("no daemon answers"), HasSubstr("12B-03 was recording when it was last")));
  for (const auto& span : line_with(page, "cam00")) EXPECT_EQ(span.style, Style::dim);
  const auto never = lay_out({.trouble = "no daemon answers on X"}, kSmall);
  EXPECT_THAT(text_of(never), AllOf(HasSubstr("waiting for the daemon"), HasSubstr("no daemon answers on X")));
}

TEST(RigPage, SaysThatTheDaemonIsSilent) {
  auto state = studio();
  state.status_age_s = 0.4;
  EXPECT_THAT(text_of(lay_out(state, kSmall)), Not(HasSubstr("has not answered")));
  state.status_age_s = 3.2;
  EXPECT_THAT(text_of(lay_out(state, kSmall)), HasSubstr("the daemon has not answered for 3 s"));
}

TEST(RigPage, SaysWhyNothingCanBeRecordedBeforeAnythingElse) {
  auto state = studio();
  state.status->warnings = {"a small thing"};
  state.status->preflight = {{"links", Verdict::look, "slow", "faster"},
                             {"disk of /takes", Verdict::stop, "is full", "move takes away"}};
  const auto spans = concerns(state);
  ASSERT_EQ(spans.size(), 3U);
  EXPECT_EQ(spans[0].text, "cannot record: disk of /takes: is full; move takes away");
  EXPECT_EQ(spans[0].style, Style::alarm);
  EXPECT_EQ(spans[1].text, "a small thing");
  EXPECT_EQ(spans[2].text, "links: slow; faster");
}

TEST(RigPage, PutsTroubledCamerasFirstWhereNotAllFit) {
  auto state = studio(40);
  state.status->cameras[33].state = "lost";
  const auto page = lay_out(state, kSmall);
  EXPECT_THAT(text_of(page[4]), StartsWith("cam33"));
  EXPECT_THAT(text_of(page), HasSubstr("more cameras, no worse than these"));
}

TEST(RigPage, TellsTimeThatNoDiskHas) {
  EXPECT_EQ(clock_text(0.0), "00:00");
  EXPECT_EQ(clock_text(-5.0), "00:00");
  EXPECT_EQ(clock_text(3599.9), "59:59");
  EXPECT_EQ(clock_text(3600.0), "1:00:00");
  EXPECT_EQ(clock_text(std::numeric_limits<double>::infinity()), "99999:59:59");
}

TEST(PageText, CutsAndFillsByColumnsNotBytes) {
  EXPECT_EQ(left_in("größer", 4), "größ");
  EXPECT_EQ(left_in("é", 3), "é  ");
  EXPECT_EQ(right_in("12", 4), "  12");
  std::string text = "né";
  erase_last(text);
  EXPECT_EQ(text, "n");
  for (const char32_t code : {U'a', U'é', U'日', U'\U0001F3AC'}) {
    text = utf8(code);
    erase_last(text);
    EXPECT_EQ(text, "") << static_cast<unsigned>(code);
  }
}

TEST(PageText, WrapsAtSpacesAndCutsWhatHasNone) {
  EXPECT_EQ(wrapped("one two three", 8), (std::vector<std::string>{"one two", "  three"}));
  EXPECT_EQ(wrapped("abcdefghij", 6), (std::vector<std::string>{"abcdef", "  ghij"}));
  EXPECT_EQ(wrapped("short", 80), (std::vector<std::string>{"short"}));
}

}  // namespace
}  // namespace rotunda::rig
