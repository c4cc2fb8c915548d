#pragma once
// One take from its first trigger to its closed files: the frame sets that come are written by the recorder's thread,
// which also closes those whose deadline has passed. What the disk cannot take in time is written as holes, never
// dropped silently.
#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "capture/base/bounded_queue.h"
#include "capture/base/host_clock.h"
#include "capture/take/take_writer.h"
#include "config/rig_config.h"
#include "rig/client.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/frame_set_stream.h"

namespace rotunda::rig {

class TakeSession {
 public:
  // Makes the take's folder and fires the first trigger soon after. Throws InvalidInput (name taken or not a name),
  // DeviceError (no camera streams), std::system_error (no room, no link to the cameras).
  // `onlooker` is shown every set.
  TakeSession(const config::RigConfig& rig, const TakeRequest& request, CameraFleet& fleet, Onlooker onlooker);
  ~TakeSession();  // stops and closes the take

  void request_stop();  // returns at once
  // Throws DeviceError for a mark when nothing records any more; of a closed take its take.yaml is changed.
  void annotate(const TakeAnnotation& annotation);
  TakeProgress progress() const;
  // Waits until the progress differs from `seen` or the take is closed, or for so long.
  TakeProgress wait_for_change(const TakeProgress& seen, std::chrono::milliseconds timeout) const;
  const FrameSetStream& stream() const { return stream_; }
  // Frames by camera that the disk was too slow for.
  std::map<capture::CameraId, std::uint64_t> too_slow_for() const;
  std::size_t queued() const { return queue_.size(); }
  bool stopping() const { return stop_requested_; }

 private:
  void enqueue(capture::FrameSet&& set);
  void leave_out(capture::FrameSet& set);
  void record();
  void write(const capture::FrameSet& set);
  void write_annotations();
  void give_up(const std::string& failure);
  void close();
  void tell_clock_step();
  void tell_cameras();
  void tell(const std::string& incident);

  Onlooker onlooker_;
  std::filesystem::path folder_;
  std::vector<capture::TakeCamera> cameras_;  // that have a file in this take
  std::size_t most_queued_;
  capture::BoundedQueue<capture::FrameSet> queue_;
  FrameSetStream stream_;
  capture::ClockStepWatch clock_steps_;        // touched by the recorder only
  std::optional<capture::TakeWriter> writer_;  // until the take is closed; touched by the recorder only

  mutable std::mutex progress_mutex_;
  mutable std::condition_variable changed_;
  TakeProgress progress_;
  std::map<capture::CameraId, std::uint64_t> too_slow_for_;
  TakeAnnotation said_;             // and not yet with the writer
  std::vector<std::string> marks_;  // likewise

  std::atomic<bool> stop_requested_ = false;
  std::jthread recorder_;  // last
};

// Frame sets to record for a request: its count, its duration times the rate, or nothing.
std::optional<std::uint64_t> wanted_frame_sets(const TakeRequest& request, double rate_hz);

}  // namespace rotunda::rig
