#include "capture/sync/clock_model.h"

#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr nanoseconds kJump = 50ms;        // more than that and its bracket off the line is a clock that was set
constexpr nanoseconds kSpanForDrift = 1s;  // a shorter span says nothing about parts per million
constexpr nanoseconds kNarrowest = 1us;    // brackets below are limited by the clocks' own steps

nanoseconds half_width(const ClockReading& reading) {
  return std::max((reading.answered - reading.asked) / 2, kNarrowest);
}

Timestamp middle(const ClockReading& reading) {
  return reading.asked + (reading.answered - reading.asked) / 2;
}

double count(nanoseconds duration) {
  return static_cast<double>(duration.count());
}

nanoseconds rounded(double ns) {
  return nanoseconds(std::llround(ns));
}

}  // namespace

Timestamp ClockMap::rig_time(DeviceTime device) const {
  const auto since = device - device_origin;
  return rig_origin + since + rounded((rate - 1.0) * count(since));
}

void ClockModel::add(const ClockReading& reading) {
  if (reading.answered < reading.asked) throw InvalidInput("a clock reading was answered before it was asked");
  if (!readings_.empty()) {
    const bool backwards = reading.device < readings_.back().device;
    if (backwards || std::chrono::abs(rig_time(reading.device) - middle(reading)) > kJump + half_width(reading)) {
      readings_.clear();
      map_.rate = 1.0;
      ++resets_;
    }
  }
  readings_.push_back(reading);
  if (readings_.size() > options_.readings) readings_.pop_front();
  fit();
}

// Least squares, weighted by the square of how narrow a bracket is: one reading held up for 5 ms weighs nothing beside
// those of 50 us. Times count from the narrowest reading's, so that doubles hold nanoseconds.
void ClockModel::fit() {
  const auto best = std::min_element(readings_.begin(), readings_.end(),
                                     [](const auto& a, const auto& b) { return half_width(a) < half_width(b); });
  error_ = half_width(*best);
  map_.device_origin = best->device;
  map_.rig_origin = middle(*best);
  double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const auto& reading : readings_) {
    const double weight = std::pow(count(error_) / count(half_width(reading)), 2);
    const double device = count(reading.device - map_.device_origin);
    const double ahead = count(middle(reading) - map_.rig_origin) - device;
    w += weight;
    x += weight * device;
    y += weight * ahead;
    xx += weight * device * device;
    xy += weight * device * ahead;
  }
  const bool spans = readings_.back().device - readings_.front().device >= kSpanForDrift;
  const double spread = xx - x * x / w;
  const double limit = options_.drift_limit_ppm * 1e-6;
  const double slope = spans && spread > 0.0 ? std::clamp((xy - x * y / w) / spread, -limit, limit) : map_.rate - 1.0;
  map_.rate = 1.0 + slope;
  map_.rig_origin += rounded((y - slope * x) / w);
}

Timestamp ClockModel::rig_time(DeviceTime device) const {
  if (!ready()) throw InvalidInput("a clock model without readings knows no time");
  return map_.rig_time(device);
}

DeviceTime ClockModel::device_time(Timestamp rig) const {
  if (!ready()) throw InvalidInput("a clock model without readings knows no time");
  const auto since = rig - map_.rig_origin;
  return map_.device_origin + since + rounded((1.0 / map_.rate - 1.0) * count(since));
}

double ClockModel::drift_ppm() const {
  return (1.0 / map_.rate - 1.0) * 1e6;
}

nanoseconds ClockModel::error() const {
  return error_;
}

}  // namespace rotunda::capture
