#pragma once
// The page's table of cameras: a row each, columns by the room there is.
#include "rig/tui/page_state.h"
#include "rig/tui/page_text.h"

namespace rotunda::rig {

// The table's head, then at most `rows` cameras. Where more do not fit, those in trouble come first and the last row
// tells how many are not shown. `stale`: the numbers are old, all of it is dim.
std::vector<Line> camera_rows(const PageState& state, PageSize room, bool stale);

// "3 late, 1 packets lost" or, where that is too wide, "4: late 3 wire 1"; "-" for none.
std::string drops_by_cause(const std::map<std::string, std::uint64_t>& missing, int width);

// "====|  ": filled to the score, with a mark where the peak is. Both 0 .. 1.
std::string focus_bar(double score, double peak, int width);

}  // namespace rotunda::rig
