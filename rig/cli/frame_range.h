#pragma once
#include <cstddef>
#include <string>
#include <utility>

namespace rotunda::rig {

// "A:B", half-open, counted from 0; "A:" to the end, ":B" from the start, "A" that frame alone. Throws InvalidInput.
std::pair<std::size_t, std::size_t> frame_range(const std::string& text);

}  // namespace rotunda::rig
