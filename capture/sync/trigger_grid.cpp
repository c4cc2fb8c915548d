#include "capture/sync/trigger_grid.h"

#include <fmt/format.h>

#include <cmath>

#include "config/errors.h"

namespace rotunda::capture {

namespace {

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

}  // namespace

Timestamp TriggerGrid::time_of(std::uint64_t trigger) const {
  return start + period * static_cast<std::chrono::nanoseconds::rep>(trigger);
}

std::int64_t TriggerGrid::nearest(Timestamp time) const {
  return floor_divide((time - start + period / 2).count(), period.count());
}

std::chrono::nanoseconds period_of(double rate_hz) {
  if (!(rate_hz > 0 && rate_hz <= 10000))
    throw InvalidInput(fmt::format("trigger rate {} Hz: expected more than 0 and at most 10000", rate_hz));
  return std::chrono::nanoseconds(std::llround(1e9 / rate_hz));
}

TriggerGrid grid_from(Timestamp earliest, std::chrono::nanoseconds period) {
  if (period.count() <= 0) throw InvalidInput(fmt::format("trigger period {} ns: expected more", period.count()));
  const std::int64_t periods = -floor_divide(-earliest.time_since_epoch().count(), period.count());  // rounded up
  return {Timestamp(period * periods), period};
}

}  // namespace rotunda::capture
