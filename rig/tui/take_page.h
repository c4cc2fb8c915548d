#pragma once
// The page's list of takes, and its help.
#include "rig/tui/page_state.h"
#include "rig/tui/page_text.h"

namespace rotunda::rig {

// At most `room.rows` lines; the selected take is among them.
std::vector<Line> take_view(const PageState& state, PageSize room);
std::vector<Line> help_view();

}  // namespace rotunda::rig
