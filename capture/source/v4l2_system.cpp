#include "capture/source/v4l2_system.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

template <class Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

// "/dev/video12" -> 12; -1 for what is no such name.
int number_of(const fs::path& node) {
  constexpr std::string_view prefix = "video";
  const std::string name = node.filename().string();
  if (name.rfind(prefix, 0) != 0) return -1;
  int number = -1;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + prefix.size(), end, number);
  return read.ptr == end && read.ec == std::errc{} ? number : -1;
}

class Kernel final : public V4l2System {
 public:
  int open(const std::string& path) override {
    return uninterrupted([&] { return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); });
  }
  void close(int fd) override { ::close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) override {
    return uninterrupted([&] { return ::ioctl(fd, request, argument); });
  }
  void* map(int fd, std::size_t bytes, std::int64_t offset) override {
    void* address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    return address == MAP_FAILED ? nullptr : address;
  }
  void unmap(void* address, std::size_t bytes) override { ::munmap(address, bytes); }
  int poll(int fd, std::chrono::milliseconds timeout) override {
    pollfd waiting{.fd = fd, .events = POLLIN, .revents = 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(timeout.count()));
    if (ready < 0) return errno == EINTR ? 0 : -1;
    return ready == 0 ? 0 : waiting.revents;
  }

  std::chrono::nanoseconds monotonic_now() override {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
  }
  Timestamp rig_now() override { return RigClock::now(); }

  std::vector<std::string> nodes() override {
    std::vector<fs::path> found;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator("/dev", none))
      if (number_of(entry.path()) >= 0) found.push_back(entry.path());
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return number_of(a) < number_of(b); });
    return {found.begin(), found.end()};
  }

  // device/ is the USB interface, its parent the USB device.
  std::string serial_of(const std::string& node) override {
    std::error_code none;
    const auto name = fs::canonical(node, none).filename();
    const auto interface = fs::canonical(fs::path("/sys/class/video4linux") / name / "device", none);
    if (none) return "";
    std::string serial;
    std::getline(std::ifstream(interface.parent_path() / "serial"), serial);
    return serial;
  }
};

}  // namespace

V4l2System& kernel_v4l2() {
  static Kernel kernel;
  return kernel;
}

// The rig's clock is read between two readings of the other; of three tries the closest counts.
Timestamp rig_time_of(V4l2System& system, std::chrono::nanoseconds monotonic) {
  auto closest = std::chrono::nanoseconds::max();
  Timestamp answer;
  for (int i = 0; i < 3; ++i) {
    const auto before = system.monotonic_now();
    const auto rig = system.rig_now();
    const auto after = system.monotonic_now();
    if (after - before >= closest) continue;
    closest = after - before;
    answer = rig - (before + closest / 2) + monotonic;
  }
  return answer;
}

}  // namespace rotunda::capture
