#pragma once
// This machine's clocks, and when somebody sets them. RigClock (frame.h) is TAI as it was when the process first asked,
// carried on by CLOCK_BOOTTIME: NTP and PTP may still bend its rate, as they bend both, but settimeofday, a first
// contact with a time server or a TAI offset that comes late no longer make takes jump. Whoever records tells of a
// step; when nothing runs the rig follows.
#include <chrono>
#include <functional>
#include <optional>

namespace rotunda::capture {

// Both read at the same moment, to a microsecond or so; since their own zeros.
struct HostClocks {
  std::chrono::nanoseconds tai{}, boot{};
};
HostClocks read_host_clocks();

// A difference below is how exactly the two can be read on a busy machine.
inline constexpr std::chrono::nanoseconds kSmallestClockStep{std::chrono::milliseconds(1)};

// How far this machine's TAI is ahead of RigClock: 0 until somebody sets it.
std::chrono::nanoseconds host_clock_ahead();
// From now on RigClock shows this machine's TAI again. Only while nothing runs: times from before are another clock's.
void follow_host_clock();

class ClockStepWatch {
 public:
  using Read = std::function<HostClocks()>;
  explicit ClockStepWatch(Read read = read_host_clocks) : read_(std::move(read)), ahead_(ahead()) {}

  // By how much the clock was set since the last look; nothing: it was not.
  std::optional<std::chrono::nanoseconds> look();

 private:
  std::chrono::nanoseconds ahead() const;

  Read read_;
  std::chrono::nanoseconds ahead_;  // TAI less time since boot
};

}  // namespace rotunda::capture
