#pragma once
// A take's triggers from the USB trigger box: the cameras hang on its lines (trigger mode `line`). The box numbers the
// pulses; the grid follows their times on the rig's clock, so that its crystal's drift never shifts a number.
#include "capture/sync/trigger_box.h"
#include "rig/daemon/take_trigger.h"

namespace rotunda::rig {

class BoxTrigger final : public TakeTrigger {
 public:
  // Opens the box and sets it. Throws DeviceError.
  BoxTrigger(const config::TriggerConfig& config, std::optional<std::uint64_t> wanted);

  std::optional<std::uint64_t> wanted() const override { return wanted_; }
  capture::TriggerGrid plan() override;
  void start(GridSink grid) override;
  void stop() override;
  capture::TriggerCounts counts() const override;
  std::string failure() const override;
  std::vector<std::string> warnings() const override;

 private:
  void take_pulse(const capture::Pulse& pulse);

  std::optional<std::uint64_t> wanted_;
  std::chrono::nanoseconds period_{};  // as the box really keeps it
  capture::Timestamp planned_;
  std::mutex sink_mutex_;
  GridSink sink_;
  capture::TriggerBox box_;  // last: its thread uses the rest
};

}  // namespace rotunda::rig
