#pragma once
// The daemon's one object: the cameras, the running take if there is one, and what can be asked of them.
// State: idle (no camera streams), armed, live (triggered, watched, not recorded), recording, stopping. Safe from any
// thread.
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/live_mocap.h"
#include "rig/daemon/live_session.h"
#include "rig/daemon/live_surfaces.h"
#include "rig/daemon/picture_watch.h"
#include "rig/daemon/preflight_watch.h"
#include "rig/daemon/take_review.h"
#include "rig/daemon/take_session.h"

namespace rotunda::rig {

class RigDaemon {
 public:
  // With surfaces of what the cameras see, or without.
  explicit RigDaemon(const config::RigConfig& rig, bool with_surfaces = true);
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
  // Writes a contact sheet of the newest pictures, of one camera or all; live for a moment if no trigger is given now.
  // Throws InvalidInput for a camera that is none of the rig's, and what write_contact_sheet throws.
  std::vector<IdentifiedCamera> identify(const IdentifyRequest& request);
  // Live before and after takes, or not. What keeps it from being so is a warning of the status.
  void set_live(bool on);
  LiveSurfaces* surfaces() { return surfaces_.get(); }  // none if not asked for
  LiveMocap& mocap() { return mocap_; }                 // follows nobody without surfaces

 private:
  std::string state_locked() const;
  bool recording() const;
  bool recording_locked() const;
  void require_free_locked() const;
  RigStatus session_status() const;  // without the preflight's findings
  double expected_locked() const;
  void add_session(RigStatus& status, const FrameSetStream& stream) const;
  void keep_live(std::stop_token stop);
  void go_live_or_not();
  void look_at(const capture::FrameSet& set, const std::vector<capture::CameraId>& cameras);
  void renew_surfaces();
  void review_closed_take();
  void follow_clock();
  bool go_live_for_a_moment();  // true if it was not before
  std::vector<CameraWorker*> workers_called(const std::string& name) const;

  config::RigConfig rig_;
  CameraFleet fleet_;
  PictureWatch watch_;
  LiveMocap mocap_;                         // before the surfaces, which it looks on
  std::unique_ptr<LiveSurfaces> surfaces_;  // none if not asked for
  mutable std::mutex mutex_;
  std::condition_variable_any live_changed_;
  std::shared_ptr<TakeSession> take_;  // the running or last one
  bool plating_ = false;
  bool live_wanted_ = false;
  std::string live_problem_;
  std::unique_ptr<LiveSession> live_;
  std::chrono::steady_clock::time_point session_begun_;  // of live or take
  std::weak_ptr<TakeSession> reviewed_;                  // the last take that was handed to `review_`
  std::unique_ptr<TakeReview> review_;                   // none without surfaces
  std::jthread live_keeper_;
  std::optional<PreflightWatch> preflight_;  // last: asks for the status
};

}  // namespace rotunda::rig
