#pragma once
// The moments of a take's triggers: trigger k happens at start + k * period, on the rig's clock (TAI).
// Frames are given to triggers by their time on this grid, never by the order they come in.
#include <cstdint>

#include "capture/frame.h"

namespace rotunda::capture {

struct TriggerGrid {
  Timestamp start;  // of trigger 0
  std::chrono::nanoseconds period{};

  Timestamp time_of(std::uint64_t trigger) const;

  // The trigger next to `time`, which may lie before the first: then negative. Halfway goes to the later one.
  std::int64_t nearest(Timestamp time) const;
};

// Nanoseconds between triggers, to the nearest one. Throws InvalidInput unless 0 < rate_hz <= 10000.
std::chrono::nanoseconds period_of(double rate_hz);

// The grid whose first trigger is the first multiple of the period (counted from the clock's zero, so that rigs and
// restarts share one grid) at or after `earliest`. Throws InvalidInput for a period that is not positive.
TriggerGrid grid_from(Timestamp earliest, std::chrono::nanoseconds period);

}  // namespace rotunda::capture
