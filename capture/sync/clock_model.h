#pragma once
// The rig's clock seen from a device that runs on its own: rig time = a + b * device time, fitted to readings of both
// clocks taken at nearly the same moment. A reading brackets the device's answer between two rig times, so the middle
// is wrong by half the bracket at most; readings that were held up are known by their width and count little (the
// minimum-delay filter of NTP: Mills, RFC 5905, 10). Pure, no clock of its own.
#include <chrono>
#include <deque>
#include <optional>

#include "capture/frame.h"

namespace rotunda::capture {

// Nanoseconds of a device's own clock, whenever it began.
using DeviceTime = std::chrono::nanoseconds;

// A straight line from a device's clock to the rig's. By default the device's clock is the rig's.
struct ClockMap {
  DeviceTime device_origin{};
  Timestamp rig_origin;
  double rate = 1.0;  // rig nanoseconds a device nanosecond

  Timestamp rig_time(DeviceTime device) const;
};

struct ClockReading {
  Timestamp asked, answered;  // rig times round the device's answer
  DeviceTime device{};
};

struct ClockModelOptions {
  std::size_t readings = 64;       // kept; older ones go
  double drift_limit_ppm = 300.0;  // crystals stay well within; a fit beyond is not believed
};

class ClockModel {
 public:
  explicit ClockModel(const ClockModelOptions& options = {}) : options_(options) {}

  // Throws InvalidInput for a reading that was answered before it was asked. A device clock that runs backwards or
  // jumps by more than 50 ms and the reading's bracket against the rig's has been set anew: what was known of it is
  // forgotten.
  void add(const ClockReading& reading);

  bool ready() const { return !readings_.empty(); }
  // Of a model without readings: InvalidInput.
  Timestamp rig_time(DeviceTime device) const;
  DeviceTime device_time(Timestamp rig) const;
  const ClockMap& map() const { return map_; }  // as of the last reading

  double drift_ppm() const;                // how much faster the device's clock runs than the rig's
  std::chrono::nanoseconds error() const;  // half the width of the best bracket in use: a bound where drift is steady
  std::uint64_t resets() const { return resets_; }

 private:
  void fit();

  ClockModelOptions options_;
  std::deque<ClockReading> readings_;
  ClockMap map_;
  std::chrono::nanoseconds error_{};
  std::uint64_t resets_ = 0;
};

}  // namespace rotunda::capture
