// Footage streamed from the frame cache: SECONDS of ten cameras of 720 x 576 at 25 Hz, each picture asked for when its
// exposure is over, as the cameras' sender does; beside it the same bytes as
// fast as the disk gives them, and at the same times by bare pread(). The file
// cache of the kernel is emptied of them before each. Prints pictures late, resident memory, CPU, and how long opening
// takes.
//   cache_bench [seconds]     writes 104 MB a second of footage to the folder for temporary files
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <system_error>
#include <thread>

#include "capture/base/unique_fd.h"
#include "simulator/studio/act_player.h"
#include "simulator/studio/camera_layout.h"

namespace rotunda {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::size_t kCameras = 10, kPictureBytes = 720 * 576;
constexpr auto kPeriod = 40ms;

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return of(usage.ru_utime) + of(usage.ru_stime);
}

double resident_megabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::stod(line.substr(6)) / 1000.0;
  return 0.0;
}

// Writes what is not on disk yet, then lets the kernel forget it.
void forget_files_of(const fs::path& folder) {
  for (const auto& item : fs::recursive_directory_iterator(folder)) {
    if (!item.is_regular_file()) continue;
    const capture::UniqueFd file(open(item.path().c_str(), O_RDONLY | O_CLOEXEC));
    if (!file || fdatasync(file.get()) != 0 || posix_fadvise(file.get(), 0, 0, POSIX_FADV_DONTNEED) != 0)
      throw std::system_error(errno, std::generic_category(), item.path().string());
  }
}

simulator::PictureKey key() {
  return simulator::picture_key("noise", simulator::camera_layout({}), {}, capture::PixelFormat::bayer_rg8);
}

void write_footage(const fs::path& folder, int frames) {
  const simulator::EntryShape shape{frames, std::vector<std::uint64_t>(kCameras, kPictureBytes)};
  auto entry = simulator::FrameCache({.folder = folder}).open(key(), shape);
  std::mt19937_64 random(1);
  simulator::PictureSet pictures(kCameras, std::vector<std::uint8_t>(kPictureBytes));
  for (int frame = 0; frame < frames; ++frame) {
    for (auto& picture : pictures)
      for (std::size_t i = 0; i < picture.size(); i += 64) picture[i] = static_cast<std::uint8_t>(random());
    entry.write(frame, pictures);
  }
}

struct Run {
  double cpu_percent = 0.0, resident = 0.0, slowest_ms = 0.0;  // of a core; megabytes at most; for one frame set
};

// Calls `set` for every frame set when its time has come.
Run at_the_rate(int frames, const std::function<void(int)>& set) {
  Run run;
  const double cpu = cpu_seconds();
  const auto begun = std::chrono::steady_clock::now();
  for (int frame = 0; frame < frames; ++frame) {
    std::this_thread::sleep_until(begun + frame * kPeriod);
    const auto before = std::chrono::steady_clock::now();
    set(frame);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - before;
    run.slowest_ms = std::max(run.slowest_ms, took.count());
    if (frame % 25 == 0) run.resident = std::max(run.resident, resident_megabytes());
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  run.cpu_percent = 100.0 * (cpu_seconds() - cpu) / took.count();
  return run;
}

void print(const char* what, const Run& run) {
  fmt::print("{:<12} CPU {:.1f} % of a core, resident {:.0f} MB, slowest frame set {:.1f} ms\n", what, run.cpu_percent,
             run.resident, run.slowest_ms);
}

std::vector<fs::path> frame_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& item : fs::recursive_directory_iterator(folder))
    if (item.path().extension() == ".pictures") files.push_back(item.path());
  std::sort(files.begin(), files.end());
  return files;
}

// What the disk gives at most, now: all footage read one file after the other without a pause.
void disk_alone(const fs::path& folder) {
  std::vector<char> memory(kCameras * kPictureBytes + 4096);
  double bytes = 0.0, slowest = 0.0;
  const auto begun = std::chrono::steady_clock::now();
  for (const auto& path : frame_files(folder)) {
    const auto before = std::chrono::steady_clock::now();
    const capture::UniqueFd file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
    const auto got = pread(file.get(), memory.data(), memory.size(), 0);
    if (got < 0) throw std::system_error(errno, std::generic_category(), path.string());
    bytes += static_cast<double>(got);
    slowest =
        std::max(slowest, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count());
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  fmt::print("{:<12} {:.0f} MB/s ({:.0f} are needed), slowest frame set {:.1f} ms\n", "disk alone",
             1e-6 * bytes / took.count(), 25e-6 * static_cast<double>(kCameras * kPictureBytes), slowest);
}

void bare_run(const fs::path& folder, int frames) {
  const auto files = frame_files(folder);
  std::vector<char> memory(kCameras * kPictureBytes);
  print("bare pread", at_the_rate(frames, [&](int frame) {
          const auto& path = files.at(static_cast<std::size_t>(frame));
          const capture::UniqueFd file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
          if (pread(file.get(), memory.data(), memory.size(), 0) < static_cast<ssize_t>(memory.size()))
            throw std::system_error(errno, std::generic_category(), path.string());
        }));
}

void cache_run(const fs::path& folder, int frames) {
  const auto begun = std::chrono::steady_clock::now();
  auto entry = simulator::FrameCache({.folder = folder}).find(key());
  if (!entry || !entry->missing().empty()) throw std::runtime_error("the footage is not whole");
  const auto player = simulator::stream_from_disk(std::move(*entry));
  const std::chrono::duration<double, std::milli> opened = std::chrono::steady_clock::now() - begun;
  std::uint64_t missing = 0;
  const auto run = at_the_rate(frames, [&](int frame) {
    for (std::size_t camera = 0; camera < kCameras; ++camera)
      missing += player->picture_at(camera, capture::Timestamp(kPeriod * frame)).empty() ? 1 : 0;
  });
  print("frame cache", run);
  const auto counts = player->counts();
  fmt::print("{:<12} {} of {} pictures late, {} missing, opened in {:.1f} ms\n", "", counts.late,
             kCameras * static_cast<std::size_t>(frames), missing, opened.count());
}

void run(int seconds) {
  const int frames = seconds * 25;
  auto name = (fs::temp_directory_path() / "cache_bench.XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
  const fs::path folder = name;
  struct Removed {
    const fs::path& folder;
    ~Removed() { fs::remove_all(folder); }
  } const removed{folder};
  write_footage(folder, frames);
  fmt::print("{} frame sets, {:.0f} MB\n", frames, 1e-6 * frames * static_cast<double>(kCameras * kPictureBytes));
  forget_files_of(folder);
  disk_alone(folder);
  forget_files_of(folder);
  bare_run(folder, frames);
  forget_files_of(folder);
  cache_run(folder, frames);
}

}  // namespace
}  // namespace rotunda

int main(int argc, char** argv) {
  try {
    rotunda::run(argc > 1 ? std::max(1, std::atoi(argv[1])) : 30);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    fmt::print(stderr, "cache_bench: {}\n", error.what());
    return EXIT_FAILURE;
  }
}
