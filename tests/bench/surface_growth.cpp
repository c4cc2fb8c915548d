#include "tests/bench/surface_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <string>

#include "config/median.h"
#include "simulator/studio/camera_layout.h"

namespace rotunda::bench {
namespace {

// Of this process since forget_peak(), megabytes.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024.0;
  return std::nan("");
}

void forget_peak() {
  std::ofstream("/proc/self/clear_refs") << "5";  // proc(5)
}

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void print_growth(std::span<const recon::SilhouetteView> views, std::span<const cv::Mat> pictures,
                  recon::SurfaceOptions options, int runs) {
  std::vector<double> cpu;
  for (const double cell : {0.020, 0.010, 0.005}) {
    options.cell_size = cell;
    std::vector<double> cpu_runs, wall_runs;
    recon::SurfaceReport report;
    forget_peak();
    for (int run = 0; run < runs; ++run) {
      const auto wall = std::chrono::steady_clock::now();
      const double before = cpu_ms();
      report = recon::reconstruct_surface(views, pictures, options).report;
      cpu_runs.push_back(cpu_ms() - before);
      wall_runs.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count());
    }
    cpu.push_back(median(cpu_runs));
    fmt::print(
        "cells of {:2.0f} mm: cpu {:8.1f} ms   wall {:8.1f} ms   {:7} -> {:7} triangles   peak memory {:.0f} MB\n",
        1e3 * cell, cpu.back(), median(wall_runs), report.extracted_triangles, report.triangles, peak_memory());
    fmt::print("   ");
    for (const auto& stage : report.stages) fmt::print(" {} {:.0f}", stage.name, stage.wall_ms);
    fmt::print(" (wall ms)\n");
  }
  fmt::print("growth exponent 20 to 10 mm {:.2f}, 10 to 5 mm {:.2f} (a dense grid: 3)\n", std::log2(cpu[1] / cpu[0]),
             std::log2(cpu[2] / cpu[1]));
}

void print_growth(const SurfaceStudy& study, const std::filesystem::path& keep, int runs) {
  const auto moment = moments_of(study, keep).front();
  recon::SurfaceOptions options;
  options.bounds = simulator::kStageVolume;
  print_growth(recon::silhouette_views(moment.cameras, moment.mattes), moment.pictures, options, runs);
}

}  // namespace rotunda::bench
