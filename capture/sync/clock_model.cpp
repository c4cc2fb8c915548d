#include "capture/sync/clock_model.h"

#include <algorithm>
#include <cmath>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr nanoseconds kJump = 1s;          // more than that between two readings is a clock that was set
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

void ClockModel::add(const ClockReading& reading) {
  if (reading.answered < reading.asked) throw InvalidInput("a clock reading was answered before it was asked");
  if (!readings_.empty()) {
    const bool backwards = reading.device < readings_.back().device;
    if (backwards || std::chrono::abs(rig_time(reading.device) - middle(reading)) > kJump) {
      readings_.clear();
      rate_ = 1.0;
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
  device_origin_ = best->device;
  rig_origin_ = middle(*best);
  double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const auto& reading : readings_) {
    const double weight = std::pow(count(error_) / count(half_width(reading)), 2);
    const double device = count(reading.device - device_origin_);
    const double ahead = count(middle(reading) - rig_origin_) - device;
    w += weight;
    x += weight * device;
    y += weight * ahead;
    xx += weight * device * device;
    xy += weight * device * ahead;
  }
  const bool spans = readings_.back().device - readings_.front().device >= kSpanForDrift;
  const double spread = xx - x * x / w;
  const double limit = options_.drift_limit_ppm * 1e-6;
  const double slope = spans && spread > 0.0 ? std::clamp((xy - x * y / w) / spread, -limit, limit) : rate_ - 1.0;
  rate_ = 1.0 + slope;
  rig_origin_ += rounded((y - slope * x) / w);
}

Timestamp ClockModel::rig_time(DeviceTime device) const {
  if (!ready()) throw InvalidInput("a clock model without readings knows no time");
  const auto since = device - device_origin_;
  return rig_origin_ + since + rounded((rate_ - 1.0) * count(since));
}

DeviceTime ClockModel::device_time(Timestamp rig) const {
  if (!ready()) throw InvalidInput("a clock model without readings knows no time");
  const auto since = rig - rig_origin_;
  return device_origin_ + since + rounded((1.0 / rate_ - 1.0) * count(since));
}

double ClockModel::drift_ppm() const {
  return (1.0 / rate_ - 1.0) * 1e6;
}

nanoseconds ClockModel::error() const {
  return error_;
}

}  // namespace rotunda::capture
