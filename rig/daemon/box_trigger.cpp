#include "rig/daemon/box_trigger.h"

#include <fmt/format.h>

#include "config/errors.h"

namespace rotunda::rig {
namespace {

using namespace std::chrono_literals;

constexpr auto kLead = 100ms;  // time for the cameras' buffers and the box to be ready for the first pulse

std::chrono::nanoseconds microseconds(double us) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(us * 1e3));
}

capture::PulseTrain train_of(const config::TriggerConfig& config, std::optional<std::uint64_t> wanted) {
  capture::PulseTrain train{
      .period = capture::period_of(config.rate_hz), .width = microseconds(config.pulse_width_us), .count = wanted};
  for (const double delay_us : config.line_delays_us) train.delays.push_back(microseconds(delay_us));
  return train;
}

}  // namespace

BoxTrigger::BoxTrigger(const config::TriggerConfig& config, std::optional<std::uint64_t> wanted)
    : wanted_(wanted), box_(config.box, [this](const capture::Pulse& pulse) { take_pulse(pulse); }) {
  period_ = box_.set(train_of(config, wanted)).period;
}

capture::TriggerGrid BoxTrigger::plan() {
  planned_ = capture::RigClock::now() + kLead + period_;
  return {planned_, period_};
}

void BoxTrigger::start(GridSink grid) {
  const auto first = box_.start(planned_);
  grid({first, period_});
  const std::lock_guard lock(sink_mutex_);
  sink_ = std::move(grid);
}

void BoxTrigger::take_pulse(const capture::Pulse& pulse) {
  const std::lock_guard lock(sink_mutex_);
  if (sink_) sink_({pulse.time - static_cast<std::int64_t>(pulse.number) * period_, period_});
}

void BoxTrigger::stop() {
  try {
    box_.stop();
  } catch (const DeviceError&) {  // failure() tells
  }
}

capture::TriggerCounts BoxTrigger::counts() const {
  const auto status = box_.status();
  return {.fired = status.pulses, .finished = !status.running};
}

std::string BoxTrigger::failure() const {
  const auto status = box_.status();
  return status.lost
             ? fmt::format("trigger box {} was lost after {} pulses; plug it in again", box_.serial(), status.pulses)
             : "";
}

std::vector<std::string> BoxTrigger::warnings() const {
  const auto status = box_.status();
  if (status.events_lost == 0) return {};
  return {fmt::format("{} pulses of trigger box {} were not told in time; only its counter knows them",
                      status.events_lost, box_.serial())};
}

}  // namespace rotunda::rig
