#include "simulator/gige/camera_clock.h"

#include <cmath>

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr nanoseconds kInitializing = 200ms;
constexpr nanoseconds kSlaveListens = 1s;   // one announce interval
constexpr nanoseconds kMasterListens = 3s;  // announceReceiptTimeout: three intervals without a better clock
constexpr double kFirstError = 20e3;        // ns left after the servo has stepped the clock
constexpr double kServoTime = 0.5e9;        // ns in which the servo takes the error to 1/e
constexpr nanoseconds kCalibrated = 1us;

// SplitMix64 (Steele, Lea, Flood 2014), as a number of [-1, 1).
double noise(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t x = seed * 0x9E3779B97F4A7C15 + index;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EB;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1.0p-52 - 1.0;
}

nanoseconds scaled(nanoseconds duration, double factor) {
  return nanoseconds{std::llround(static_cast<double>(duration.count()) * factor)};
}

}  // namespace

CameraClockOptions realistic_clock(std::uint64_t seed) {
  return {.ptp = true,
          .drift_ppm = 25.0 * noise(seed, 1),
          .wander = nanoseconds{70 + std::llround(50.0 * noise(seed, 2))},
          .seed = seed};
}

CameraClock::CameraClock(const CameraClockOptions& options, PtpStatus role, Timestamp powered_up)
    : options_(options), role_(role), anchor_(powered_up) {
  if (options_.ptp) ptp_since_ = powered_up;
}

void CameraClock::enable_ptp(Timestamp now) {
  if (!ptp_since_) ptp_since_ = now;
}

void CameraClock::disable_ptp(Timestamp now) {
  if (!ptp_since_) return;
  anchor_reading_ = reading(now);
  anchor_ = now;
  ptp_since_.reset();
}

void CameraClock::reset(Timestamp now) {
  if (ptp_since_) return;
  anchor_ = now;
  anchor_reading_ = {};
}

std::optional<Timestamp> CameraClock::disciplined_since() const {
  if (!ptp_since_) return std::nullopt;
  return *ptp_since_ + kInitializing + (role_ == PtpStatus::master ? kMasterListens : kSlaveListens);
}

PtpStatus CameraClock::status(Timestamp now) const {
  if (!ptp_since_) return PtpStatus::disabled;
  if (now < *ptp_since_ + kInitializing) return PtpStatus::initializing;
  if (now < *disciplined_since()) return PtpStatus::listening;
  if (role_ == PtpStatus::master) return PtpStatus::master;
  return std::chrono::abs(servo_error(now)) < kCalibrated ? PtpStatus::slave : PtpStatus::uncalibrated;
}

bool CameraClock::is_synchronised(Timestamp now) const {
  const auto port = status(now);
  return port == PtpStatus::slave || port == PtpStatus::master;
}

nanoseconds CameraClock::offset_from_master(Timestamp now) const {
  const auto port = status(now);
  if (port != PtpStatus::slave && port != PtpStatus::uncalibrated) return 0ns;
  return servo_error(now) + wander_at(now);
}

nanoseconds CameraClock::servo_error(Timestamp now) const {
  if (options_.wander.count() == 0) return 0ns;  // an ideal servo
  const double since = static_cast<double>((now - *disciplined_since()).count());
  const double first = noise(options_.seed, 3) < 0.0 ? -kFirstError : kFirstError;
  return nanoseconds{std::llround(first * std::exp(-since / kServoTime))};
}

// From second to second to another place, on a straight line.
nanoseconds CameraClock::wander_at(Timestamp now) const {
  const auto since = now.time_since_epoch();
  const auto second = std::chrono::floor<std::chrono::seconds>(since);
  const double share = std::chrono::duration<double>(since - second).count();
  const auto place = static_cast<std::uint64_t>(second.count()) + 16;  // 1 to 3 are taken
  const double here = noise(options_.seed, place), next = noise(options_.seed, place + 1);
  return scaled(options_.wander, here + share * (next - here));
}

Timestamp CameraClock::free_reading(Timestamp true_time) const {
  const nanoseconds passed = true_time - anchor_;
  return anchor_reading_ + passed + scaled(passed, 1e-6 * options_.drift_ppm);
}

Timestamp CameraClock::reading(Timestamp true_time) const {
  const auto disciplined = disciplined_since();
  if (!disciplined || true_time < *disciplined) return free_reading(true_time);
  if (role_ == PtpStatus::master) return true_time;
  return true_time + servo_error(true_time) + wander_at(true_time);
}

// The clock's rate differs from 1 by 1e-4 at most, so each step is 1e4 times nearer.
Timestamp CameraClock::true_time(Timestamp wanted) const {
  Timestamp at = disciplined_since() ? wanted : anchor_ + (wanted - anchor_reading_);
  for (int step = 0; step < 4; ++step) at += wanted - reading(at);
  return at;
}

nanoseconds CameraClock::true_duration(nanoseconds counted) const {
  return ptp_since_ ? counted : counted - scaled(counted, 1e-6 * options_.drift_ppm);
}

}  // namespace rotunda::simulator
