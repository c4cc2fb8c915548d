#pragma once
// One take from its first trigger to its closed files: has the triggers fired, assembles frame sets, writes them.
// Threads: the trigger's, and the recorder's, which also closes frame sets whose deadline has passed.
// Camera threads only hand frames in. What the disk cannot take in time is written as holes, never dropped silently.
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/sync/frame_set_assembler.h"
#include "capture/take/take_writer.h"
#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/take_trigger.h"

namespace rotunda::rig {

class TakeSession : public FrameReceiver {
 public:
  // Makes the take's folder and fires the first trigger soon after. Throws InvalidInput (name taken or not a name),
  // DeviceError (no camera streams), std::system_error (no room, no link to the cameras).
  TakeSession(const config::RigConfig& rig, const TakeRequest& request, CameraFleet& fleet);
  ~TakeSession() override;  // stops and closes the take

  void request_stop();  // returns at once
  TakeProgress progress() const;
  // Waits until the progress differs from `seen` or the take is closed, or for so long.
  TakeProgress wait_for_change(const TakeProgress& seen, std::chrono::milliseconds timeout) const;
  std::uint64_t late_triggers() const;
  std::vector<std::string> trigger_warnings() const { return trigger_->warnings(); }
  std::uint64_t late_frames() const;
  std::size_t queued() const { return queue_.size(); }
  bool stopping() const { return stop_requested_; }

 private:
  void take_frame(capture::Frame&& frame) override;
  void take_incomplete(const capture::IncompleteFrame& incomplete) override;
  bool records(const capture::CameraId& camera) const;
  void move_grid(const capture::TriggerGrid& grid);
  void enqueue(std::vector<capture::FrameSet> sets);
  void record();
  void close_due_sets();
  bool all_sets_queued() const;
  std::optional<std::uint64_t> triggers_to_record() const;
  void write(const capture::FrameSet& set);
  void give_up(const std::string& failure);
  void close();

  CameraFleet& fleet_;
  std::size_t most_queued_;
  std::unique_ptr<TakeTrigger> trigger_;
  std::filesystem::path folder_;
  std::optional<capture::TakeWriter> writer_;  // until the take is closed; touched by the recorder only

  std::vector<capture::CameraId> cameras_;  // that have a file in this take

  mutable std::mutex assembler_mutex_;
  capture::TriggerGrid grid_;
  capture::FrameSetAssembler assembler_;
  capture::BoundedQueue<capture::FrameSet> queue_;

  mutable std::mutex progress_mutex_;
  mutable std::condition_variable changed_;
  TakeProgress progress_;

  std::atomic<bool> stop_requested_ = false;
  std::jthread recorder_;  // last
};

// Frame sets to record for a request: its count, its duration times the rate, or nothing.
std::optional<std::uint64_t> wanted_frame_sets(const TakeRequest& request, double rate_hz);

}  // namespace rotunda::rig
