#pragma once
// The daemon's one object: the cameras, the running take if there is one, and what can be asked of them.
// State: idle (no camera streams), armed, live (triggered, watched, not recorded), recording, stopping. Safe from any
// thread.
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/live_session.h"
#include "rig/daemon/picture_watch.h"
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
  // Of the running take; note and circle also of the last. Throws DeviceError when there is none, or nothing records
  // that could be marked.
  TakeProgress annotate_take(const TakeAnnotation& annotation);
  // Throws what record_plate throws, and DeviceError while a take is recording. Live goes on afterwards.
  PlateReport record_plate(std::uint64_t frame_sets);
  // Live before and after takes, or not. What keeps it from being so is a warning of the status.
  void set_live(bool on);

 private:
  std::string state_locked() const;
  bool recording_locked() const;
  void require_free_locked() const;
  void add_session(RigStatus& status, const FrameSetStream& stream) const;
  void keep_live(std::stop_token stop);
  void go_live_or_not();
  void follow_clock();

  config::RigConfig rig_;
  CameraFleet fleet_;
  PictureWatch watch_;
  mutable std::mutex mutex_;
  std::condition_variable_any live_changed_;
  std::shared_ptr<TakeSession> take_;  // the running or last one
  bool plating_ = false;
  bool live_wanted_ = false;
  std::string live_problem_;
  std::unique_ptr<LiveSession> live_;
  std::jthread live_keeper_;  // last
};

}  // namespace rotunda::rig
