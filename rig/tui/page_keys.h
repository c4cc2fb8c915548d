#pragma once
// What a key does to the page, and what it asks the daemon for.
#include <optional>

#include "rig/tui/page_state.h"

namespace rotunda::rig {

// Characters are their code points; these have none.
inline constexpr char32_t kKeyUp = 0x110001, kKeyDown = 0x110002;
inline constexpr char32_t kKeyEnter = '\n', kKeyEscape = 27, kKeyBackspace = 127, kKeyInterrupt = 3;

std::optional<PageRequest> press(PageState& state, char32_t key);

}  // namespace rotunda::rig
