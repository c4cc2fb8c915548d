#include "rig/daemon/take_trigger.h"

#include <fmt/format.h>

#include <cmath>
#include <exception>

#include "capture/sync/action_command.h"
#include "rig/daemon/box_trigger.h"

namespace rotunda::rig {
namespace {

capture::TriggerScheduleOptions schedule_for(const config::TriggerConfig& trigger, capture::TriggerMode mode,
                                             std::optional<std::uint64_t> wanted) {
  const auto now = capture::RigClock::now();
  if (mode != capture::TriggerMode::action || trigger.lead_periods == 0)
    return capture::immediate_triggers(trigger.rate_hz, wanted, now);
  auto schedule = capture::scheduled_triggers(trigger.rate_hz, wanted, now);
  schedule.lead = trigger.lead_periods * schedule.grid.period;
  schedule.grid = capture::grid_from(now + schedule.lead + schedule.grid.period, schedule.grid.period);
  return schedule;
}

std::unique_ptr<capture::ActionCommandSender> action_sender(const config::TriggerConfig& trigger,
                                                            capture::TriggerMode mode) {
  if (mode != capture::TriggerMode::action) return nullptr;
  return std::make_unique<capture::ActionCommandSender>(
      capture::ActionSenderOptions{.interface_address = trigger.interface_address});
}

class ScheduledTrigger final : public TakeTrigger {
 public:
  ScheduledTrigger(const config::TriggerConfig& config, capture::TriggerMode mode, std::optional<std::uint64_t> wanted,
                   CameraFleet& fleet)
      : config_(config), mode_(mode), fleet_(fleet), actions_(action_sender(config, mode)), wanted_(wanted) {}

  std::optional<std::uint64_t> wanted() const override { return wanted_; }
  capture::TriggerGrid plan() override {
    options_ = schedule_for(config_, mode_, wanted_);
    behind_ = fleet_.behind_rig_clock();
    return options_.grid;
  }
  void start(GridSink) override {  // the plan is kept exactly
    schedule_.emplace(options_, [this](const capture::Trigger& trigger) { fire(trigger); });
  }
  void stop() override { schedule_->stop(); }
  capture::TriggerCounts counts() const override { return schedule_->counts(); }

  std::string failure() const override {
    try {
      schedule_->rethrow_failure();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  std::vector<std::string> warnings() const override {
    std::vector<std::string> told;
    if (!actions_) return told;
    for (const auto& [address, acks] : actions_->acks()) {
      if (acks.late > 0)
        told.push_back(fmt::format("the camera at {} got {} of {} triggers too late; raise trigger.lead_periods",
                                   address, acks.late, actions_->sent()));
      if (acks.overflow > 0)
        told.push_back(fmt::format("the camera at {} had no room for {} of {} triggers; lower trigger.lead_periods",
                                   address, acks.overflow, actions_->sent()));
      if (acks.no_reference_time > 0)
        told.push_back(
            fmt::format("the camera at {} has no time from PTP: it cannot fire at a given moment; see to the "
                        "PTP master",
                        address));
    }
    return told;
  }

 private:
  void fire(const capture::Trigger& trigger) {
    if (mode_ == capture::TriggerMode::action)
      actions_->send({.device_key = config_.device_key,
                      .group_key = config_.group_key,
                      .group_mask = config_.group_mask,
                      .at = config_.lead_periods > 0 ? std::optional(trigger.at - behind_) : std::nullopt});
    if (mode_ == capture::TriggerMode::software)
      for (const auto& worker : fleet_.workers()) worker->request_software_trigger();
  }

  config::TriggerConfig config_;
  capture::TriggerMode mode_;
  CameraFleet& fleet_;
  std::unique_ptr<capture::ActionCommandSender> actions_;  // in trigger mode `action`
  std::optional<std::uint64_t> wanted_;
  capture::TriggerScheduleOptions options_;
  std::chrono::nanoseconds behind_{};                 // the cameras' clocks; of scheduled actions
  std::optional<capture::TriggerSchedule> schedule_;  // last: its thread uses the rest
};

}  // namespace

std::unique_ptr<TakeTrigger> make_take_trigger(const config::TriggerConfig& config, capture::TriggerMode mode,
                                               std::optional<std::uint64_t> wanted, CameraFleet& fleet) {
  if (mode == capture::TriggerMode::line) return std::make_unique<BoxTrigger>(config, wanted);
  return std::make_unique<ScheduledTrigger>(config, mode, wanted, fleet);
}

}  // namespace rotunda::rig
