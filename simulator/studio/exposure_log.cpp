#include "simulator/studio/exposure_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <atomic>
#include <cerrno>
#include <system_error>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/base/unique_fd.h"

namespace rotunda::simulator {
namespace {

constexpr std::size_t kQueued = 10'000;  // 40 s of ten cameras

struct Entry {
  Exposure exposure;
  int act_frame = 0;
};

}  // namespace

struct ExposureLog::Impl {
  Impl(const std::filesystem::path& path, std::vector<std::string> names)
      : file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644)),
        cameras(std::move(names)) {
    if (!file) throw std::system_error(errno, std::generic_category(), "cannot write " + path.string());
    writer = std::jthread([this] { write_loop(); });
  }
  ~Impl() { queue.close(); }

  void write_loop() {
    prctl(PR_SET_NAME, "exposure log");
    while (const auto entry = queue.pop()) {
      const auto& [camera, block, start, duration] = entry->exposure;
      const auto line = fmt::format(
          "{{\"camera\": \"{}\", \"block\": {}, \"exposure_start_ns\": {}, \"exposure_ns\": {}, \"act_frame\": {}}}\n",
          cameras.at(camera), block, start.time_since_epoch().count(), duration.count(), entry->act_frame);
      if (::write(file.get(), line.data(), line.size()) == static_cast<ssize_t>(line.size())) continue;
      if (lost++ == 0) spdlog::error("exposures.jsonl cannot be written: {}", std::generic_category().message(errno));
    }
  }

  capture::UniqueFd file;
  std::vector<std::string> cameras;
  capture::BoundedQueue<Entry> queue{kQueued};
  std::atomic<std::uint64_t> lost = 0;
  std::jthread writer;
};

ExposureLog::ExposureLog(const std::filesystem::path& file, std::vector<std::string> cameras)
    : impl_(std::make_unique<Impl>(file, std::move(cameras))) {}
ExposureLog::~ExposureLog() = default;

void ExposureLog::add(const Exposure& exposure, int act_frame) {
  if (!impl_->queue.try_push({exposure, act_frame})) ++impl_->lost;
}

std::uint64_t ExposureLog::lost() const {
  return impl_->lost;
}

}  // namespace rotunda::simulator
