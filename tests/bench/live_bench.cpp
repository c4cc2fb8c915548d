// What the live way costs a frame set, stage by stage, on one thread and on two, and what the offline surface of the
// same mattes with its colours costs on one: live_bench TAKE [CELL_MM [FRAMES]].
// Prints medians; CPU time is of the whole process.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "capture/take/take_reader.h"
#include "recon/live_reconstruction.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"

namespace {

using namespace rotunda;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

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

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: live_bench TAKE [CELL_MM [FRAMES]]\n");
    return 2;
  }
  const capture::TakeReader take(argv[1]);
  const auto count = std::min<std::size_t>(take.frame_set_count(), argc > 3 ? std::strtoul(argv[3], nullptr, 10) : 20);
  auto studio = recon::read_take_studio(take, std::nullopt);
  recon::make_live_keys(take, studio.views);
  studio.views.volume.reset();
  const Eigen::AlignedBox3d usual(Eigen::Vector3d(-1.5, -1.0, 0.0), Eigen::Vector3d(1.5, 1.0, 2.0));  // of a rig file
  const recon::LiveOptions options{.bounds = studio.volume.value_or(usual),
                                   .cell_size = argc > 2 ? std::atof(argv[2]) * 1e-3 : 0.0};
  std::vector<capture::FrameSet> sets;
  for (std::size_t i = 0; i < count; ++i) sets.push_back(take.read(i * take.frame_set_count() / count));
  for (const int threads : {1, 2}) measure(sets, studio.views, options, threads);
  measure_offline(sets.front(), studio.views, options);
}
