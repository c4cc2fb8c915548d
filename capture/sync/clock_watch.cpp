#include "capture/sync/clock_watch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

namespace rotunda::capture {
namespace {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr int kFirstReadings = 4;         // of which the narrowest counts
constexpr nanoseconds kSameClock = 10ms;  // a host's clock may be that far from the cameras' master, and do no harm
constexpr nanoseconds kFarOff = 500ms;

double microseconds(nanoseconds time) {
  return static_cast<double>(time.count()) * 1e-3;
}

// Slave, SLAVE, slave: cameras spell it as they like.
std::string lower(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word;
}

// The whole seconds that explain `ahead`, if TAI less UTC does.
std::optional<std::chrono::seconds> utc_shift(nanoseconds ahead, nanoseconds tolerance) {
  for (const auto shift : {kTaiLessUtc, -kTaiLessUtc})
    if (std::chrono::abs(ahead - shift) <= tolerance) return shift;
  return std::nullopt;
}

}  // namespace

ClockWatch::ClockWatch(FeatureAccess& camera, const ClockWatchOptions& options, Now now)
    : camera_(camera), options_(options), now_(std::move(now)), names_(names_in(camera, options.use_ptp)) {
  if (names_.tick_frequency.empty()) return;
  if (const auto hertz = read_integer(camera_, names_.tick_frequency); hertz && *hertz > 0)
    ns_a_tick_ = 1e9 / static_cast<double>(*hertz);
}

ClockWatch::Names ClockWatch::names_in(FeatureAccess& camera, bool use_ptp) {
  Names names;
  if (use_ptp) {
    names.enable = first_of(camera, {"PtpEnable", "GevIEEE1588"});
    names.status = first_of(camera, {"PtpStatus", "GevIEEE1588Status"});
    names.latch = first_of(camera, {"PtpDataSetLatch", "GevIEEE1588DataSetLatch"});
    names.offset = first_of(camera, {"PtpOffsetFromMaster", "GevIEEE1588OffsetFromMaster"});
    names.identity = first_of(camera, {"PtpClockID", "GevIEEE1588ClockId"});
    names.parent = first_of(camera, {"PtpParentClockID", "GevIEEE1588ParentClockId"});
    names.grandmaster = first_of(camera, {"PtpGrandmasterClockID"});
  }
  names.time_latch = first_of(camera, {"TimestampLatch"});
  if (!names.time_latch.empty()) names.time_value = first_of(camera, {"TimestampLatchValue"});  // nanoseconds
  if (names.time_value.empty()) {
    names.time_latch = first_of(camera, {"GevTimestampControlLatch"});
    names.time_value = first_of(camera, {"GevTimestampValue"});  // ticks
    names.tick_frequency = first_of(camera, {"GevTimestampTickFrequency"});
  }
  return names;
}

void ClockWatch::begin() {
  if (!names_.enable.empty() && !names_.status.empty()) {
    const auto on = camera_.read(names_.enable);
    if (on != "true" && on != "1") camera_.write(names_.enable, "true");
  }
  std::optional<ClockReading> first, last;
  for (int i = 0; i < kFirstReadings; ++i) {
    last = read_clock();
    if (!first) first = last;
    if (last) model_.add(*last);
  }
  if (first && last && last->device > first->device) return;
  names_.time_latch.clear();  // a latch that does not latch
  model_ = ClockModel();
}

// The bracket is the latch alone: the value is read at leisure.
std::optional<ClockReading> ClockWatch::read_clock() {
  if (names_.time_latch.empty() || names_.time_value.empty()) return std::nullopt;
  const Timestamp asked = now_();
  camera_.execute(names_.time_latch);
  const Timestamp answered = std::max(asked, now_());
  const auto ticks = read_integer(camera_, names_.time_value);
  if (!ticks) return std::nullopt;
  const DeviceTime device =
      ns_a_tick_ == 1.0 ? DeviceTime(*ticks) : DeviceTime(std::llround(static_cast<double>(*ticks) * ns_a_tick_));
  return ClockReading{asked, answered, device};
}

ClockState ClockWatch::look() {
  ClockState state;
  const auto reading = read_clock();
  if (reading) model_.add(*reading);
  look_at_ptp(state);
  if (const bool follows = state.kind == "ptp slave" || state.kind == "ptp master"; !follows) {
    look_at_own_clock(state, reading);
    return state;
  }
  map_ = {};
  if (reading) compare_with_rig(state, *reading);
  return state;
}

void ClockWatch::look_at_ptp(ClockState& state) {
  if (names_.status.empty()) {
    state.settled = true;
    return;
  }
  if (!names_.latch.empty()) camera_.execute(names_.latch);
  const auto port = lower(camera_.read(names_.status));
  state.kind = "ptp " + port;
  const auto told = [&](const std::string& name) { return name.empty() ? "" : camera_.read(name); };
  state.identity = told(names_.identity);
  state.settled = port == "slave" || port == "master";
  if (port != "slave") {
    if (!state.settled)
      state.problem = fmt::format(
          "its PTP clock is {}, not slave: see that a PTP master (ptp4l) runs on the cameras' network", port);
    return;
  }
  state.parent = told(names_.parent);
  state.grandmaster = told(names_.grandmaster);
  if (names_.offset.empty()) return;
  if (const auto offset = read_integer(camera_, names_.offset)) {
    state.offset = nanoseconds(*offset);
    state.error = std::chrono::abs(*state.offset);
    state.settled = *state.error <= options_.ptp_offset_limit;
    if (!state.settled)
      state.problem = fmt::format(
          "its clock is {:.1f} us from its PTP master's, the limit is {:.1f} us "
          "(trigger.ptp_offset_limit_us); see to the network between them",
          microseconds(*state.offset), microseconds(options_.ptp_offset_limit));
  }
}

void ClockWatch::look_at_own_clock(ClockState& state, const std::optional<ClockReading>& reading) {
  if (!model_.ready()) {
    if (state.kind.empty()) state.kind = "none";
    return;
  }
  if (state.kind.empty()) state.kind = "model";
  map_ = model_.map();
  state.error = model_.error();
  if (reading)
    state.offset = reading->asked + (reading->answered - reading->asked) / 2 - map_.rig_time(reading->device);
}

// A PTP clock beside this machine's, which the rig's triggers go by.
void ClockWatch::compare_with_rig(ClockState& state, const ClockReading& reading) {
  const nanoseconds half = (reading.answered - reading.asked) / 2;
  const nanoseconds behind = reading.asked + half - Timestamp(reading.device);
  const nanoseconds tolerance = kSameClock + half;
  if (std::chrono::abs(behind) <= tolerance) return;
  if (const auto shift = utc_shift(behind, tolerance)) {
    state.moved = *shift;
    map_.rig_origin += *shift;
    state.problem = fmt::format(
        "its PTP clock counts {}, {} s {} this machine's TAI: its time stamps are moved; set the PTP master's time "
        "scale{}",
        *shift > 0s ? "UTC" : "TAI", std::abs(shift->count()), *shift > 0s ? "behind" : "ahead of",
        *shift > 0s ? " to TAI" : ", or this machine's TAI offset (adjtimex), right");
    return;
  }
  map_ = model_.map();
  state.error = model_.error();
  state.problem = fmt::format(
      "its PTP master's time is {:.3f} s {} this machine's: time stamps are moved by a model of it, and scheduled "
      "triggers will not fire as they should; let one clock lead both (ptp4l, phc2sys)",
      std::abs(std::chrono::duration<double>(behind).count()), behind > 0s ? "behind" : "ahead of");
}

std::vector<std::string> ptp_domain_problems(const std::vector<NamedClock>& cameras) {
  std::vector<CameraId> masters;
  std::map<std::string, std::vector<CameraId>> followers;  // by the grandmaster's, else the parent's identity
  std::map<std::chrono::seconds, std::vector<CameraId>> scales;
  std::string master_identity;
  for (const auto& [camera, clock] : cameras) {
    if (clock.kind == "ptp master") {
      masters.push_back(camera);
      master_identity = clock.identity;
    }
    if (clock.kind == "ptp slave") {
      const auto& leader = clock.grandmaster.empty() ? clock.parent : clock.grandmaster;
      if (!leader.empty()) followers[leader].push_back(camera);
    }
    if (clock.kind == "ptp slave" || clock.kind == "ptp master") scales[clock.moved].push_back(camera);
  }
  if (masters.size() == 1 && !master_identity.empty() && !followers.empty())
    followers[master_identity].push_back(masters.front());
  std::vector<std::string> problems;
  if (masters.size() > 1)
    problems.push_back(
        fmt::format("{} are PTP masters, each of a network of its own: exactly one clock must lead; see "
                    "that all cameras hang on one network that lets PTP through",
                    fmt::join(masters, " and ")));
  if (followers.size() > 1) {
    std::vector<std::string> parties;
    for (const auto& [leader, party] : followers)
      parties.push_back(fmt::format("{} ({})", leader, fmt::join(party, ", ")));
    problems.push_back(
        fmt::format("cameras follow {} PTP masters: {}; leave one", parties.size(), fmt::join(parties, ", ")));
  }
  if (scales.size() > 1)
    problems.push_back(
        fmt::format("some PTP clocks count TAI, some UTC ({}): no action command can be scheduled for "
                    "all; set them to one time scale",
                    fmt::join(scales.rbegin()->second, ", ")));
  return problems;
}

nanoseconds guessed_clock_shift(Timestamp stamp, Timestamp came) {
  const nanoseconds behind = came - stamp;
  if (std::chrono::abs(behind) <= kFarOff) return 0ns;
  if (const auto shift = utc_shift(behind, kFarOff)) return *shift;
  return behind;
}

}  // namespace rotunda::capture
