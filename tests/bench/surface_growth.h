#pragma once
// How time and memory of the surface grow from cells of 20 mm to 5 mm.
#include <filesystem>
#include <span>
#include <vector>

#include "recon/hull/surface.h"
#include "tests/bench/surface_study.h"

namespace rotunda::bench {

// Prints a line a cell size and the exponents of time between them; memory is the peak of the whole process while it
// ran. `pictures`: one a view, or none.
void print_growth(std::span<const recon::SilhouetteView> views, std::span<const cv::Mat> pictures,
                  recon::SurfaceOptions options, int runs);
// Of a study's first moment, everything included.
void print_growth(const SurfaceStudy& study, const std::filesystem::path& keep, int runs);

}  // namespace rotunda::bench
