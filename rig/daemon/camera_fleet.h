#pragma once
// All cameras of a rig: a worker each. Frames of whichever camera go to the one receiver of the moment.
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "config/rig_config.h"
#include "rig/daemon/camera_worker.h"

namespace rotunda::rig {

class FrameReceiver {
 public:
  virtual ~FrameReceiver() = default;
  virtual void take_frame(capture::Frame&& frame) = 0;                           // on the camera's stream thread
  virtual void take_incomplete(const capture::IncompleteFrame& incomplete) = 0;  // likewise
};

class CameraFleet {
 public:
  explicit CameraFleet(const config::RigConfig& rig);
  ~CameraFleet();  // closes all cameras at the same time: one that is gone takes seconds

  // Waits until every camera has been tried once; then some may still be missing. False if told to stop meanwhile.
  bool wait_until_tried(std::stop_token stop) const;

  const std::vector<std::unique_ptr<CameraWorker>>& workers() const { return workers_; }
  std::size_t streaming() const;
  CameraWorker& worker(const capture::CameraId& camera) const;  // InvalidInput if the rig has none of that name
  // Software if any camera that streams is armed so; else the rig's.
  capture::TriggerMode trigger_mode() const;
  // Of the cameras that stream.
  std::vector<capture::NamedClock> clocks() const;
  // What the cameras' clocks show less than the rig's: TAI less UTC where all of them count UTC, else 0.
  std::chrono::nanoseconds behind_rig_clock() const;
  // Has the cameras on one link take turns, by the bandwidth they need at this rate. Throws DeviceError with the
  // arithmetic if it does not fit.
  void share_links(double rate_hz);
  // Arms all cameras for trigger_mode(); waits a few seconds for those that have to change.
  void agree_on_trigger_mode();

  // Who gets the frames from now on; null drops them. The receiver before is out of use when this returns.
  void set_receiver(FrameReceiver* receiver);
  // No receiver any more, if it is still this one.
  void release(const FrameReceiver* receiver);

 private:
  capture::TriggerMode rig_mode_;
  std::mutex receiver_mutex_;
  FrameReceiver* receiver_ = nullptr;
  std::vector<std::unique_ptr<CameraWorker>> workers_;  // last: they deliver into the members above
};

capture::SourceSettings source_settings(const config::CameraConfig& camera, const config::RigConfig& rig);

}  // namespace rotunda::rig
