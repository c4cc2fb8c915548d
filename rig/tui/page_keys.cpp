#include "rig/tui/page_keys.h"

#include <fmt/format.h>

#include <utility>

#include "rig/tui/page_text.h"

namespace rotunda::rig {
namespace {

using Kind = PageRequest::Kind;
using Answer = std::optional<PageRequest>;

constexpr std::size_t kLongestInput = 200;

Answer say(PageState& state, std::string message) {
  state.message = std::move(message);
  return std::nullopt;
}

Answer open_prompt(PageState& state, Prompt prompt, std::string text) {
  state.prompt = prompt;
  state.input = std::move(text);
  return std::nullopt;
}

const ListedTake* selected_take(const PageState& state) {
  return state.selected < state.takes.size() ? &state.takes[state.selected] : nullptr;
}

// The typed line is done.
Answer accept(PageState& state) {
  const auto prompt = std::exchange(state.prompt, Prompt::none);
  const auto text = std::exchange(state.input, "");
  if (prompt == Prompt::scene) {
    state.scene = text;
    return open_prompt(state, Prompt::shot, state.shot);
  }
  if (prompt == Prompt::shot) {
    state.shot = text;
    state.slate_known = true;
    return say(state, fmt::format("the next take is of scene {} shot {}", state.scene, state.shot));
  }
  PageRequest request{.kind = Kind::note, .text = text};
  if (state.view == View::takes) {
    if (!selected_take(state)) return std::nullopt;
    request.kind = Kind::note_take;
    request.take = *selected_take(state);
  }
  return request;
}

Answer type(PageState& state, char32_t key) {
  if (key == kKeyEnter || key == '\r') return accept(state);
  if (key == kKeyEscape || key == kKeyInterrupt) {
    state.prompt = Prompt::none;
    state.input.clear();
  } else if (key == kKeyBackspace || key == '\b') {
    erase_last(state.input);
  } else if (key >= ' ' && key < 0x110000 && state.input.size() < kLongestInput) {
    state.input += utf8(key);
  }
  return std::nullopt;
}

Answer quit(PageState& state) {
  state.quit = true;
  return std::nullopt;
}

Answer go_to(PageState& state, View view) {
  state.view = view;
  state.message.clear();
  if (view == View::takes) return PageRequest{.kind = Kind::list_takes};
  return std::nullopt;
}

Answer record(PageState& state) {
  if (recording(state)) return say(state, fmt::format("take {} is recording; s stops it", state.status->take.name));
  state.message = "starting a take ...";
  return PageRequest{.kind = Kind::record, .scene = state.scene, .shot = state.shot};
}

Answer stop(PageState& state) {
  if (!recording(state)) return say(state, "nothing is recording");
  state.message = "stopping ...";
  return PageRequest{.kind = Kind::stop};
}

Answer mark(PageState& state) {
  if (!recording(state)) return say(state, "nothing is recording: there is no moment to mark");
  return PageRequest{.kind = Kind::mark};
}

Answer press_in_rig(PageState& state, char32_t key) {
  const bool has_take = state.status && !state.status->take.name.empty();
  switch (key) {
    case 'a': {
      const bool live = state.status && state.status->state == "live";
      state.message = live ? "disarming ..." : "arming ...";
      return PageRequest{.kind = live ? Kind::disarm : Kind::arm};
    }
    case 'r':
      return record(state);
    case 's':
      return stop(state);
    case 'm':
      return mark(state);
    case 'n':
      return has_take ? open_prompt(state, Prompt::note, state.status->take.note)
                      : say(state, "no take yet to note on");
    case 'c':
      if (!has_take) return say(state, "no take yet to circle");
      return PageRequest{.kind = Kind::circle, .on = !state.status->take.circled};
    case 'l':
      return open_prompt(state, Prompt::scene, state.scene);
    case 'p':
      state.peak.clear();
      return say(state, "focus peaks forgotten");
    case 't':
      return go_to(state, View::takes);
    default:
      return std::nullopt;
  }
}

Answer press_in_takes(PageState& state, char32_t key) {
  const auto* take = selected_take(state);
  switch (key) {
    case kKeyUp:
      if (state.selected > 0) --state.selected;
      return std::nullopt;
    case kKeyDown:
      if (state.selected + 1 < state.takes.size()) ++state.selected;
      return std::nullopt;
    case kKeyEnter:
    case '\r':
      if (take) return PageRequest{.kind = Kind::play, .take = *take};
      return std::nullopt;
    case 'n':
      return take ? open_prompt(state, Prompt::note, take->note) : std::nullopt;
    case 'c':
      if (take) return PageRequest{.kind = Kind::circle_take, .on = !take->circled, .take = *take};
      return std::nullopt;
    case 't':
    case kKeyEscape:
      return go_to(state, View::rig);
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<PageRequest> press(PageState& state, char32_t key) {
  if (state.prompt != Prompt::none) return type(state, key);
  if (key == kKeyInterrupt || key == 'q') return quit(state);
  if (key == '?') return go_to(state, state.view == View::help ? View::rig : View::help);
  if (state.view == View::help) return key == kKeyEscape ? go_to(state, View::rig) : std::nullopt;
  return state.view == View::takes ? press_in_takes(state, key) : press_in_rig(state, key);
}

}  // namespace rotunda::rig
