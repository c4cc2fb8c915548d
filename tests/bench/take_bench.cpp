// What recording costs: ten cameras of 720 x 576 raw at 25 Hz are 104 MB/s. CPU seconds a second of take, beside the
// floor: the same bytes handed to the kernel by write(2), nothing else. Then what opening and reading back costs.
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/crc32c.h"
#include "capture/take/take_reader.h"
#include "capture/take/take_writer.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCameras = 10;
constexpr std::size_t kSets = 250;  // ten seconds
constexpr double kSeconds = 10.0;

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

fs::path fresh_folder() {
  const auto folder = fs::temp_directory_path() / ("rotunda-take-bench-" + std::to_string(::getpid()));
  fs::remove_all(folder);
  return folder;
}

std::vector<TakeCamera> cameras() {
  std::vector<TakeCamera> all(kCameras);
  for (std::size_t i = 0; i < kCameras; ++i)
    all[i] = {.name = "cam0" + std::to_string(i), .width = 720, .height = 576, .format = PixelFormat::bayer_rg8};
  return all;
}

// A few sets that differ, as buffers that come round again would.
std::vector<FrameSet> frame_sets() {
  std::vector<FrameSet> sets(4);
  std::uint32_t seed = 1;
  for (auto& set : sets)
    for (const auto& camera : cameras()) {
      std::vector<std::uint8_t> bytes(720 * 576);
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>((seed = seed * 1664525U + 1013904223U) >> 24U);
      set.slots.push_back({.frame = Frame{.camera = camera.name,
                                          .image = make_image(720, 576, PixelFormat::bayer_rg8, std::move(bytes))},
                           .missing_because = std::nullopt});
    }
  return sets;
}

void record(const fs::path& folder, std::vector<FrameSet>& sets, std::chrono::milliseconds period) {
  TakeWriterOptions options;
  options.folder = folder;
  options.cameras = cameras();
  TakeWriter writer(options);
  auto next = std::chrono::steady_clock::now();
  for (std::size_t trigger = 0; trigger < kSets; ++trigger) {
    FrameSet& set = sets[trigger % sets.size()];
    set.trigger = trigger;
    set.time = Timestamp(std::chrono::milliseconds(40 * trigger));
    std::this_thread::sleep_until(next += period);
    writer.write(set);
  }
  writer.finish();
}

void report(benchmark::State& state, double cpu) {
  const double takes = static_cast<double>(state.iterations());
  state.counters["core_percent_at_25Hz"] = 100.0 * cpu / takes / kSeconds;
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(kSets * kCameras * 720 * 576));
}

// In real time (40 ms a set), so that the disk is written to while recording, as it will be.
void BM_RecordTake(benchmark::State& state) {
  auto sets = frame_sets();
  double cpu = 0.0;
  for (auto _ : state) {
    const auto folder = fresh_folder();
    const double before = cpu_seconds();
    record(folder, sets, std::chrono::milliseconds(state.range(0)));
    cpu += cpu_seconds() - before;
    state.PauseTiming();
    fs::remove_all(folder);
    state.ResumeTiming();
  }
  report(state, cpu);
}
BENCHMARK(BM_RecordTake)->Arg(40)->Arg(0)->ArgName("period_ms")->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_FloorWriteToKernel(benchmark::State& state) {
  const auto sets = frame_sets();
  double cpu = 0.0;
  for (auto _ : state) {
    const auto folder = fresh_folder();
    fs::create_directories(folder);
    std::vector<int> files;
    for (const auto& camera : cameras())
      files.push_back(::open((folder / camera.name).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644));
    auto next = std::chrono::steady_clock::now();
    const double before = cpu_seconds();
    for (std::size_t i = 0; i < kSets; ++i) {
      std::this_thread::sleep_until(next += std::chrono::milliseconds(state.range(0)));
      for (std::size_t camera = 0; camera < kCameras; ++camera) {
        const auto bytes = sets[i % sets.size()].slots[camera].frame->image.bytes();
        if (::write(files[camera], bytes.data(), bytes.size()) < 0) state.SkipWithError("cannot write");
      }
    }
    cpu += cpu_seconds() - before;
    state.PauseTiming();
    for (const int file : files) ::close(file);
    fs::remove_all(folder);
    state.ResumeTiming();
  }
  report(state, cpu);
}
BENCHMARK(BM_FloorWriteToKernel)->Arg(40)->Arg(0)->ArgName("period_ms")->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_Crc32cOfFrame(benchmark::State& state) {
  const std::vector<std::uint8_t> bytes(720 * 576, 7);
  for (auto _ : state) benchmark::DoNotOptimize(crc32c(bytes));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes.size()));
}
BENCHMARK(BM_Crc32cOfFrame)->Unit(benchmark::kMicrosecond);

void BM_OpenTake(benchmark::State& state) {
  const auto folder = fresh_folder();
  auto sets = frame_sets();
  record(folder, sets, std::chrono::milliseconds(0));
  for (auto _ : state) benchmark::DoNotOptimize(TakeReader(folder).frame_set_count());
  fs::remove_all(folder);
}
BENCHMARK(BM_OpenTake)->Unit(benchmark::kMillisecond);

void BM_ReadFrameSet(benchmark::State& state) {
  const auto folder = fresh_folder();
  auto sets = frame_sets();
  record(folder, sets, std::chrono::milliseconds(0));
  const TakeReader take(folder);
  std::size_t index = 0;
  for (auto _ : state) benchmark::DoNotOptimize(take.read(index++ % take.frame_set_count()));
  fs::remove_all(folder);
}
BENCHMARK(BM_ReadFrameSet)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rotunda::capture

BENCHMARK_MAIN();
