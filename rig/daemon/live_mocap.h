#pragma once
// Live motion capture: while somebody watches, one thread of low priority follows the person in the newest silhouettes
// of those that live surfaces are made from. Nobody ever waits: silhouettes that come faster are left out, a watcher
// that is slow misses frames.
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "capture/base/bounded_queue.h"
#include "capture/frame.h"
#include "recon/live_reconstruction.h"
#include "rig/motion_frame.h"

namespace rotunda::rig {

class LiveMocap {
 public:
  using Cameras = std::shared_ptr<const std::vector<capture::CameraModel>>;  // of the sets' slots; a new one: a new rig

  LiveMocap();
  ~LiveMocap();

  // What was seen in a set, from any thread; sets that are older than the last are passed over.
  void offer(const capture::FrameSet& set, const Cameras& cameras, const std::vector<recon::LiveView>& views);
  bool is_watched() const;
  bool is_fed() const;  // sets were offered in the last seconds

 private:
  friend class MotionWatcher;
  struct Job {
    std::uint64_t trigger = 0;
    capture::Timestamp exposure;
    Cameras cameras;
    std::vector<recon::LiveView> views;
  };
  void work_off(const std::stop_token& stop);
  void publish(const Job& job, recon::LiveMotionFrame&& motion);

  capture::BoundedQueue<Job> queue_{1};
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::shared_ptr<const MotionFrame> newest_;
  std::uint64_t sequence_ = 0;  // of the newest
  int watchers_ = 0;
  capture::Timestamp offered_;  // the last set
  std::chrono::steady_clock::time_point fed_{};
  std::jthread thread_;  // last
};

// One watcher's place, from any one thread.
class MotionWatcher {
 public:
  explicit MotionWatcher(LiveMocap& mocap);
  ~MotionWatcher();
  MotionWatcher(const MotionWatcher&) = delete;
  MotionWatcher& operator=(const MotionWatcher&) = delete;

  // The newest frame that it was not handed yet, waiting so long for one.
  std::shared_ptr<const MotionFrame> next(std::chrono::milliseconds patience);

 private:
  LiveMocap& mocap_;
  std::uint64_t seen_ = 0;
};

}  // namespace rotunda::rig
