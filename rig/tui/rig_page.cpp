#include "rig/tui/rig_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rig/tui/camera_rows.h"
#include "rig/tui/take_page.h"

namespace rotunda::rig {
namespace {

constexpr double kShort_s = 600.0, kVeryShort_s = 60.0;
constexpr int kLeastColumns = 40, kLeastRows = 10;

std::string upper(std::string text) {
  for (auto& letter : text) letter = static_cast<char>(letter >= 'a' && letter <= 'z' ? letter - 'a' + 'A' : letter);
  return text;
}

Span state_badge(const PageState& state) {
  if (!state.trouble.empty()) return {" NO DAEMON ", Style::alarm};
  const auto& word = state.status->state;
  const auto badge = " " + upper(word) + " ";
  if (word == "recording" || word == "stopping") return {badge, Style::recording};
  return {badge, word == "idle" ? Style::warn : Style::title};
}

// "take 12B-03  00:12  310 frame sets, 308 whole": the running take, or how the last one ended.
Line take_words(const RigStatus& status) {
  const auto& take = status.take;
  if (take.name.empty()) return {{"no take yet", Style::dim}};
  const double seconds = status.rate_hz > 0.0 ? static_cast<double>(take.frame_sets) / status.rate_hz : 0.0;
  const bool whole = take.complete == take.frame_sets;
  Line line{
      {fmt::format("{}take {}{}", take.closed ? "last " : "", take.name, take.circled ? " (*)" : ""), Style::title},
      {fmt::format("  {}  {} frame sets, ", clock_text(seconds), take.frame_sets)},
      {whole ? "all whole" : fmt::format("{} whole", take.complete), whole ? Style::good : Style::warn}};
  if (take.marks > 0) line.push_back({fmt::format(", {} mark{}", take.marks, take.marks == 1 ? "" : "s")});
  return line;
}

Line first_line(const PageState& state) {
  Line line{state_badge(state), {"  "}};
  for (auto& span : take_words(*state.status)) line.push_back(span);
  line.push_back({"  " + state.status->rig, Style::dim});
  return line;
}

Span disk_words(const RigStatus& status) {
  if (status.seconds_left <= 0.0 && status.disk_free_bytes > 0)
    return {fmt::format("disk {:.1f} GB free", static_cast<double>(status.disk_free_bytes) * 1e-9)};
  const auto style = status.seconds_left < kVeryShort_s ? Style::alarm
                     : status.seconds_left < kShort_s   ? Style::warn
                                                        : Style::plain;
  return {fmt::format("disk {} left ({:.0f} s)", clock_text(status.seconds_left), status.seconds_left), style};
}

Line rig_line(const RigStatus& status) {
  Line line{{fmt::format("trigger {} {} Hz", status.trigger, status.rate_hz)}, {"  "}, disk_words(status)};
  if (status.spread_p99_us > 0.0)
    line.push_back({fmt::format("  in step {:.0f} us (99% {:.0f})", status.spread_median_us, status.spread_p99_us)});
  if (status.queued_frame_sets > 0)
    line.push_back({fmt::format("  {} sets wait for the disk", status.queued_frame_sets), Style::warn});
  return line;
}

// "12.4 surfaces/s, 180 ms late, 37 shed"; of sets that were shed nothing is lost but a look at them.
Span surface_words(const LiveSurfacesStatus& surfaces) {
  return {
      fmt::format("  {:.1f} surfaces/s, {:.0f} ms late, {} shed", surfaces.rate_hz, surfaces.delay_ms, surfaces.shed),
      surfaces.rate_hz > 0.0 ? Style::plain : Style::warn};
}

Line slate_line(const PageState& state) {
  const auto or_dash = [](const std::string& text) { return text.empty() ? std::string("-") : text; };
  Line line{{"slate: scene "}, {or_dash(state.scene), Style::title}, {" shot "}, {or_dash(state.shot), Style::title}};
  const auto& take = state.status->take;
  if (!take.slate.empty())
    line.push_back({fmt::format("  ({} {})", take.closed ? "last" : "now", take.slate), Style::dim});
  if (state.status->surfaces.state == "running") line.push_back(surface_words(state.status->surfaces));
  if (!take.note.empty()) line.push_back({"  note: " + take.note});
  return line;
}

Line prompt_line(const PageState& state) {
  const char* what = state.prompt == Prompt::note ? "note: " : state.prompt == Prompt::scene ? "scene: " : "shot: ";
  return {
      {what, Style::title}, {state.input}, {"_", Style::selected}, {"  (Enter keeps it, Esc drops it)", Style::dim}};
}

Line keys_line(View view) {
  static const std::vector<std::pair<const char*, const char*>> rig{
      {"a", "arm"},   {"r", "record"}, {"s", "stop"},  {"m", "mark"}, {"n", "note"},
      {"l", "slate"}, {"c", "circle"}, {"t", "takes"}, {"?", "help"}, {"q", "quit"}};
  static const std::vector<std::pair<const char*, const char*>> takes{
      {"up/down", "choose"}, {"Enter", "replay"}, {"n", "note"}, {"c", "circle"}, {"t", "back"}, {"?", "help"}};
  static const std::vector<std::pair<const char*, const char*>> help{{"?", "back"}, {"q", "quit"}};
  Line line;
  for (const auto& [key, word] : view == View::rig ? rig : view == View::takes ? takes : help) {
    line.push_back({line.empty() ? "" : " "});
    line.push_back({key, Style::key});
    line.push_back({std::string(" ") + word});
  }
  return line;
}

// The concerns, wrapped; where room ends, how many lines more there would be.
std::vector<Line> concern_lines(const PageState& state, PageSize room) {
  std::vector<Line> lines;
  for (const auto& span : concerns(state))
    for (auto& text : wrapped(span.text, room.columns)) lines.push_back({{std::move(text), span.style}});
  const auto places = static_cast<std::size_t>(std::max(0, room.rows));
  if (lines.size() > places && places > 0) {
    const auto more = lines.size() - places + 1;
    lines.resize(places);
    lines.back() = {{fmt::format("... {} lines more: rotunda status", more), Style::warn}};
  }
  lines.resize(std::min(lines.size(), places));
  return lines;
}

void append(std::vector<Line>& page, std::vector<Line> lines) {
  page.insert(page.end(), std::make_move_iterator(lines.begin()), std::make_move_iterator(lines.end()));
}

std::vector<Line> rig_view(const PageState& state, PageSize room) {
  if (!state.status) {
    std::vector<Line> page{{{" ROTUNDA ", Style::title}, {"  waiting for the daemon"}}, {}};
    append(page, concern_lines(state, {room.columns, room.rows - 2}));
    return page;
  }
  const bool stale = !state.trouble.empty();
  std::vector<Line> page{first_line(state), rig_line(*state.status), slate_line(state)};
  const int besides = 6;  // the three above, the table's head, an empty line, at least one concern
  append(page, camera_rows(state, {room.columns, room.rows - besides}, stale));
  page.push_back({});
  append(page, concern_lines(state, {room.columns, room.rows - static_cast<int>(page.size())}));
  return page;
}

}  // namespace

std::string clock_text(double seconds) {
  constexpr double kMost = 359999999.0;  // 99999 hours: more than any disk
  const auto whole = static_cast<long>(std::clamp(std::isfinite(seconds) ? seconds : kMost, 0.0, kMost));
  const auto minutes_and_seconds = fmt::format("{:02}:{:02}", whole / 60 % 60, whole % 60);
  return whole < 3600 ? minutes_and_seconds : fmt::format("{}:{}", whole / 3600, minutes_and_seconds);
}

std::vector<Line> lay_out(const PageState& state, PageSize size) {
  std::vector<Line> page;
  if (size.columns < kLeastColumns || size.rows < kLeastRows)
    page = {{{fmt::format("{} x {} is too small; 80 x 24 is enough", size.columns, size.rows)}}};
  else {
    const PageSize room{size.columns, size.rows - 2};
    page = state.view == View::rig     ? rig_view(state, room)
           : state.view == View::takes ? take_view(state, room)
                                       : help_view();
    page.resize(static_cast<std::size_t>(room.rows));
    page.push_back(state.prompt != Prompt::none ? prompt_line(state) : Line{{state.message, Style::title}});
    page.push_back(keys_line(state.view));
  }
  page.resize(static_cast<std::size_t>(std::max(0, size.rows)));
  for (auto& line : page) line = clipped(line, size.columns);
  return page;
}

}  // namespace rotunda::rig
