#pragma once
// How the law of rim_fit.h was chosen: a walk over its four numbers, one at a time, to the least sum of mean and 95th
// percentile distance over all moments of the studies, each divided by the hull's own that true mattes leave.
#include <filesystem>
#include <vector>

#include "tests/bench/surface_study.h"

namespace rotunda::bench {

// Prints every law tried, the last best one last. `keep`: as moments_of has it.
void search_rim_law(const std::vector<SurfaceStudy>& studies, const std::filesystem::path& keep);

}  // namespace rotunda::bench
