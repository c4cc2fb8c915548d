#pragma once
// The operator's page as lines of text: camera rows, what is recorded and left, warnings in words, keys. Pure; the
// terminal draws what comes out (rig/tui/terminal.h).
#include "rig/tui/page_state.h"
#include "rig/tui/page_text.h"

namespace rotunda::rig {

// Exactly `size.rows` lines, none wider than `size.columns`. Made for 80 x 24 and more; smaller ones are cut.
std::vector<Line> lay_out(const PageState& state, PageSize size);

// "1:02:03" or "02:03"; hours as many as there are.
std::string clock_text(double seconds);

// What is wrong, the worst first, each in one sentence with its style.
std::vector<Span> concerns(const PageState& state);

}  // namespace rotunda::rig
