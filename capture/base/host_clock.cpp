#include "capture/base/host_clock.h"

#include <atomic>
#include <ctime>

#include "capture/frame.h"

namespace rotunda::capture {
namespace {

using std::chrono::nanoseconds;

constexpr int kReadings = 8;  // of which the one that took the shortest counts

nanoseconds read(clockid_t clock) {
  timespec moment{};
  clock_gettime(clock, &moment);
  return std::chrono::seconds{moment.tv_sec} + nanoseconds{moment.tv_nsec};
}

nanoseconds host_ahead() {
  const auto clocks = read_host_clocks();
  return clocks.tai - clocks.boot;
}

// TAI less time since boot, as the rig keeps it. One for the process, as there is one rig clock.
std::atomic<nanoseconds::rep>& anchor() {
  static std::atomic<nanoseconds::rep> ahead{host_ahead().count()};
  return ahead;
}

}  // namespace

RigClock::time_point RigClock::now() noexcept {
  const nanoseconds ahead{anchor().load(std::memory_order_relaxed)};
  return time_point{read(CLOCK_BOOTTIME) + ahead};
}

HostClocks read_host_clocks() {
  HostClocks best;
  nanoseconds shortest = nanoseconds::max();
  for (int i = 0; i < kReadings; ++i) {
    const auto before = read(CLOCK_BOOTTIME), tai = read(CLOCK_TAI), after = read(CLOCK_BOOTTIME);
    if (after - before >= shortest) continue;
    shortest = after - before;
    best = {tai, before + shortest / 2};
  }
  return best;
}

nanoseconds host_clock_ahead() {
  return host_ahead() - nanoseconds{anchor().load()};
}

void follow_host_clock() {
  anchor() = host_ahead().count();
}

nanoseconds ClockStepWatch::ahead() const {
  const auto clocks = read_();
  return clocks.tai - clocks.boot;
}

std::optional<nanoseconds> ClockStepWatch::look() {
  const auto now = ahead();
  const auto step = now - ahead_;
  if (std::chrono::abs(step) < kSmallestClockStep) return std::nullopt;
  ahead_ = now;
  return step;
}

}  // namespace rotunda::capture
