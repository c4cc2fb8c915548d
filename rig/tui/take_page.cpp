#include "rig/tui/take_page.h"

#include <fmt/format.h>

#include <algorithm>

namespace rotunda::rig {
namespace {

std::string length_text(double seconds) {
  return seconds < 60.0 ? fmt::format("{:.1f} s", seconds) : fmt::format("{:.1f} min", seconds / 60.0);
}

Line take_row(const ListedTake& take, bool selected) {
  const auto text = fmt::format("{} {} {} {} {} {}", left_in(take.circled ? "(*)" : "", 3), left_in(take.name, 20),
                                left_in(take.state, 11), right_in(length_text(take.seconds), 9),
                                right_in(fmt::format("{}/{}", take.complete, take.frame_sets), 13),
                                take.reconstructed     ? "yes "
                                : take.at_live_quality ? "live"
                                                       : "no  ");
  const auto more =
      fmt::format("  {}{}{}", take.slate == take.name ? "" : take.slate,
                  take.slate.empty() || take.slate == take.name || take.note.empty() ? "" : ": ", take.note);
  const bool whole = take.complete == take.frame_sets && take.state != "interrupted";
  return {{text + more, selected ? Style::selected : whole ? Style::plain : Style::warn}};
}

}  // namespace

std::vector<Line> take_view(const PageState& state, PageSize room) {
  std::vector<Line> lines;
  lines.push_back({{fmt::format(" TAKES {} ", state.takes.size()), Style::title},
                   {state.status ? "  " + state.status->takes_folder.string() : ""}});
  lines.push_back({{fmt::format("    {} {} {} {} 3D   slate, note", left_in("take", 20), left_in("state", 11),
                                right_in("length", 9), right_in("whole/sets", 13)),
                    Style::title}});
  if (state.takes.empty()) lines.push_back({{"none yet", Style::dim}});
  const auto places = static_cast<std::size_t>(std::max(1, room.rows - 2));
  const auto first = state.selected < places ? 0 : state.selected - places + 1;
  for (auto i = first; i < std::min(state.takes.size(), first + places); ++i)
    lines.push_back(take_row(state.takes[i], i == state.selected));
  return lines;
}

std::vector<Line> help_view() {
  const auto key = [](const char* letter, const char* words) {
    return Line{{left_in(letter, 8), Style::key}, {words}};
  };
  return {
      {{" HELP ", Style::title}},
      key("a", "arm: cameras are triggered and watched, not recorded; again: no longer"),
      key("r  s", "record a take with the slate's scene and shot; stop it"),
      key("m", "mark this moment of the running take"),
      key("n", "note of the running or last take"),
      key("l", "slate: scene and shot of takes to come; take numbers count themselves"),
      key("c", "circle the running or last take (the one to use); again: no longer"),
      key("t", "takes: choose with the arrows; Enter replays (needs recon and a display)"),
      key("p", "forget the focus peaks"),
      key("q", "quit. It never stops a recording: the daemon goes on"),
      {},
      {{"drops   ", Style::title}, {"frames that takes lack: wire packets lost, gone camera lost,"}},
      {{"        "}, {"trigger not exposed, disk too slow, late nobody knows why"}},
      {{"clock   ", Style::title}, {"exposure start less its trigger, mean, microseconds"}},
      {{"clip%   ", Style::title}, {"share of the picture that is over-exposed"}},
      {{"focus   ", Style::title}, {"0 to 100, how much of the finest detail is there; | its peak:"}},
      {{"        "}, {"turn the ring until the number is green again"}},
      {{"colours ", Style::title}, {"green well, yellow look, red lost or urgent; words say the same"}},
  };
}

}  // namespace rotunda::rig
