// What the live way costs a frame set, stage by stage, on one thread and on two, and what the offline surface of the
// same mattes with its colours costs on one: live_bench TAKE [--cell MM] [--frames N] [--truth DIR]. With the
// simulator's truth folder also how near live surfaces come to it, beside the hull of the true mattes in cells of 10
// mm. Prints medians; CPU time is of the whole process.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <ctime>
#include <vector>

#include "capture/calibration_file.h"
#include "capture/picture.h"
#include "capture/take/take_reader.h"
#include "config/exit_code.h"
#include "config/median.h"
#include "recon/hull/genus_cut.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/visual_hull.h"
#include "recon/live_reconstruction.h"
#include "recon/mesh/mesh_file.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"
#include "tests/bench/surface_score.h"

namespace {

using namespace rotunda;

void measure(const std::vector<capture::FrameSet>& sets, const recon::StudioViews& studio,
             const recon::LiveOptions& options, int threads) {
  tbb::task_arena arena(threads);
  recon::StageClock clock;
  std::vector<double> wall_ms, cpu_ms, triangles;
  for (const auto& set : sets) {
    const auto cpu = std::clock();
    const auto wall = std::chrono::steady_clock::now();
    const auto frame = arena.execute([&] { return recon::reconstruct_live(set, studio, options, clock); });
    wall_ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count());
    cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
    triangles.push_back(static_cast<double>(frame.mesh.triangles.size()));
    if (!frame.failure.empty()) fmt::print("no surface: {}\n", frame.failure);
  }
  fmt::print("threads {}: {:.1f} ms wall, {:.1f} ms CPU a frame set, {:.0f} triangles\n", threads, median(wall_ms),
             median(cpu_ms), median(triangles));
  if (threads > 1) return;
  for (const auto& stage : clock.costs())
    fmt::print("  {:<10} {:>8.2f} ms CPU\n", stage.stage, 1e3 * stage.cpu_s / static_cast<double>(sets.size()));
}

void measure_offline(const capture::FrameSet& set, const recon::StudioViews& studio,
                     const recon::LiveOptions& options) {
  recon::StageClock clock;
  tbb::task_arena alone(1);
  const auto views = recon::key_frame(set, studio, {}, clock);
  const auto cpu = std::clock();
  const auto wall = std::chrono::steady_clock::now();
  alone.execute([&] {
    auto surface = recon::reconstruct_surface(views.cameras, views.mattes, {.bounds = options.bounds});
    recon::colour_vertices(surface.mesh, views, clock);
  });
  fmt::print("offline: {:.1f} ms wall, {:.1f} ms CPU, 10 mm cells, 20 000 triangles\n",
             std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count(),
             1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
}

// The signed field of the true mattes, its largest piece.
recon::TriangleMesh ideal_hull(const std::filesystem::path& truth, std::size_t frame,
                               const Eigen::AlignedBox3d& bounds) {
  const auto calibration = capture::read_calibration_file(truth / "calibration.yaml");
  std::vector<capture::Matte> mattes;
  for (const auto& camera : calibration.cameras)
    mattes.push_back({capture::read_grey(truth / "mattes" / camera.name / capture::frame_file_name(frame, "png"))});
  auto grid = recon::visual_hull(calibration.cameras, mattes, {.bounds = bounds});
  recon::cut_to_genus_zero(grid);
  return recon::marching_cubes(grid);
}

void score(const capture::TakeReader& take, std::size_t frames, const recon::StudioViews& studio,
           const recon::LiveOptions& options, const std::filesystem::path& truth) {
  bench::SurfaceScore live{}, ideal{}, slow{};
  recon::StageClock clock;
  for (std::size_t i = 0; i < frames; ++i) {
    const auto frame = i * take.frame_set_count() / frames;
    const auto body = recon::read_ply(truth / "meshes" / capture::frame_file_name(frame, "ply"));
    const bench::SurfaceJudge judge(body);
    const auto add = [&](bench::SurfaceScore& sum, const recon::TriangleMesh& mesh) {
      const auto one = judge.score(mesh);
      sum.mean += one.mean, sum.p95 += one.p95, sum.within_10mm += one.within_10mm;
    };
    add(live, recon::reconstruct_live(take.read(frame), studio, options, clock).mesh);
    const auto views = recon::key_frame(take.read(frame), studio, {}, clock);
    add(slow,
        recon::reconstruct_surface(views.cameras, views.mattes, recon::live_surface({.bounds = options.bounds})).mesh);
    add(ideal, ideal_hull(truth, frame, *options.bounds));
  }
  const auto print = [&](const char* name, const bench::SurfaceScore& sum) {
    const auto n = static_cast<double>(frames);
    fmt::print("{:<28} mean {:.2f} mm   p95 {:.2f} mm   truth within 10 mm {:.3f}\n", name, sum.mean / n, sum.p95 / n,
               sum.within_10mm / n);
  };
  print("baseline: ideal hull, 10 mm", ideal);
  print("baseline: offline, live", slow);
  print("live", live);
  fmt::print("live / ideal hull: {:.2f} / {:.2f}   (must: 0.85 / 0.85)\n", live.mean / ideal.mean,
             live.p95 / ideal.p95);
}

void measure_take(const std::filesystem::path& take_path, double cell_mm, std::size_t frames,
                  const std::filesystem::path& truth) {
  const capture::TakeReader take(take_path);
  const auto count = std::min(take.frame_set_count(), frames);
  auto studio = recon::read_take_studio(take, std::nullopt);
  recon::make_live_keys(take, studio.views);
  studio.views.volume.reset();
  const Eigen::AlignedBox3d usual(Eigen::Vector3d(-1.5, -1.0, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0));  // of a rig file
  const recon::LiveOptions options{.bounds = studio.volume.value_or(usual), .cell_size = cell_mm * 1e-3};
  std::vector<capture::FrameSet> sets;
  for (std::size_t i = 0; i < count; ++i) sets.push_back(take.read(i * take.frame_set_count() / count));
  for (const int threads : {1, 2}) measure(sets, studio.views, options, threads);
  if (truth.empty())
    measure_offline(sets.front(), studio.views, options);
  else
    score(take, std::min<std::size_t>(count, 5), studio.views, options, truth);
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path take_path, truth;
  double cell_mm = 0.0;
  std::size_t frames = 20;
  CLI::App app("What a live surface costs a frame set, stage by stage, and how near it comes to the truth",
               "live_bench");
  app.add_option("take", take_path, "a take's folder")->required()->check(CLI::ExistingDirectory);
  app.add_option("--cell", cell_mm, "millimetres, edge of a hull cell; else as the rig's volume has it")
      ->check(CLI::PositiveNumber);
  app.add_option("--frames", frames, "spread over the take")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--truth", truth, "the simulator's truth folder: how near live surfaces come to it")
      ->check(CLI::ExistingDirectory);
  CLI11_PARSE(app, argc, argv);
  try {
    measure_take(take_path, cell_mm, frames, truth);
    return kDone;
  } catch (...) {
    return report_current_exception("live_bench");
  }
}
