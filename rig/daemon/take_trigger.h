#pragma once
// What gives a take its triggers: the daemon's own schedule (action commands, software triggers, cameras that run by
// themselves) or the USB trigger box. Safe from several threads.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/sync/trigger.h"
#include "config/rig_config.h"
#include "rig/daemon/camera_fleet.h"

namespace rotunda::rig {

class TakeTrigger {
 public:
  // Told where the grid really lies whenever that is known better; on a thread of the trigger's.
  using GridSink = std::function<void(const capture::TriggerGrid&)>;

  virtual ~TakeTrigger() = default;                         // stops
  virtual std::optional<std::uint64_t> wanted() const = 0;  // triggers; nothing: until stopped
  // When they will come, soon from now: call again when everything else is ready, then start().
  virtual capture::TriggerGrid plan() = 0;
  virtual void start(GridSink grid) = 0;  // throws DeviceError
  virtual void stop() = 0;
  virtual capture::TriggerCounts counts() const = 0;
  virtual std::string failure() const = 0;                // why it ended early; empty if it did not
  virtual std::vector<std::string> warnings() const = 0;  // cameras or box that did not keep up, and what to do
};

// Takes hold of what it needs. `wanted`: triggers; nothing: until stopped. Throws DeviceError (no box, no link to the
// cameras), std::system_error.
std::unique_ptr<TakeTrigger> make_take_trigger(const config::TriggerConfig& config, capture::TriggerMode mode,
                                               std::optional<std::uint64_t> wanted, CameraFleet& fleet);

}  // namespace rotunda::rig
