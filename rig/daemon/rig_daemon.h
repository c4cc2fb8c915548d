#pragma once
// The daemon's one object: the cameras, the running take if there is one, and what can be asked of them.
// State: idle (no camera streams), armed, recording, stopping. Safe from any thread.
#include <memory>
#include <mutex>
#include <stop_token>

#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/take_session.h"

namespace rotunda::rig {

class RigDaemon {
 public:
  explicit RigDaemon(const config::RigConfig& rig);
  ~RigDaemon();  // closes a running take first

  bool wait_until_tried(std::stop_token stop) const { return fleet_.wait_until_tried(std::move(stop)); }
  RigStatus status() const;
  // Throws what TakeSession throws, and DeviceError while another take is recording.
  std::shared_ptr<TakeSession> start_take(const TakeRequest& request);
  // Stops the running take and waits until it is closed; throws DeviceError if none is running.
  TakeProgress stop_take();

 private:
  std::string state_locked() const;

  config::RigConfig rig_;
  CameraFleet fleet_;
  mutable std::mutex mutex_;
  std::shared_ptr<TakeSession> take_;  // the running or last one
};

}  // namespace rotunda::rig
