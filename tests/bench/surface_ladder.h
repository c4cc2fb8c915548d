#pragma once
// What each rung from the hull to the body gains: distances to the truth divided by those of the hull that true mattes
// leave, 10 mm cells (the largest piece).
#include <filesystem>
#include <vector>

#include "tests/bench/surface_study.h"

namespace rotunda::bench {

// Prints a line a moment and the means. `keep`: as moments_of has it.
void print_ladder(const std::vector<SurfaceStudy>& studies, const std::filesystem::path& keep);

}  // namespace rotunda::bench
