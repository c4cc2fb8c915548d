#pragma once
// Surfaces while cameras run: whoever has frame sets offers them, threads of this one's own, of low priority, make the
// newest into surfaces, viewers are handed the newest of those. Nobody ever waits: of sets that come faster than they
// are worked on the oldest are left out and counted, a viewer that is slow misses surfaces.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "capture/base/bounded_queue.h"
#include "capture/frame.h"
#include "config/rig_config.h"
#include "recon/live_reconstruction.h"
#include "rig/client.h"
#include "rig/live_packet.h"

namespace rotunda::rig {

// What makes the frame sets of some cameras into surfaces; called from several threads at once.
struct LiveWork {
  std::function<recon::LiveFrame(const capture::FrameSet&)> reconstruct;
  std::string remark;  // what makes them worse than they could be; empty if nothing
  std::function<recon::LiveFrame(const capture::FrameSet&)> key = {};     // without a surface
  std::shared_ptr<const std::vector<capture::CameraModel>> cameras = {};  // of the sets' slots
};

class LiveSurfaces {
 public:
  // Called on a worker with the first set of some cameras. What it throws is told in the status, and tried again.
  using MakeWork = std::function<LiveWork(const std::vector<capture::CameraId>&, const capture::FrameSet&)>;

  // Told on a worker what was keyed in a set, whether a surface came of it or not; must not wait. While it looks and
  // nobody looks at surfaces none are made: there is more time for what it does.
  struct Onlooker {
    std::function<bool()> looks;
    std::function<void(const capture::FrameSet&, const LiveWork&, const std::vector<recon::LiveView>&)> tell;
  };

  // `workers`: frame sets at once.
  LiveSurfaces(MakeWork make_work, std::size_t workers, Onlooker onlooker = {});
  ~LiveSurfaces();

  // `cameras`: of the set's slots. Sets in which a camera that is there has no frame are passed over.
  void offer(const capture::FrameSet& set, const std::vector<capture::CameraId>& cameras);
  void renew();  // a new session: calibration and plates may have changed
  LiveSurfacesStatus status() const;

 private:
  friend class LiveViewer;
  using Clock = std::chrono::steady_clock;
  // Of one session; what `make_work` gave for it.
  struct Studio {
    std::vector<capture::CameraId> cameras;
    std::string problem;  // under the surfaces' mutex
    std::mutex making;    // of what follows; held while it is made
    std::shared_ptr<const LiveWork> work;
    Clock::time_point try_again{};
  };
  struct Job {
    std::shared_ptr<Studio> studio;
    capture::FrameSet set;
  };
  struct Made {
    Clock::time_point at;
    double delay_ms;
  };

  void work_off(const std::stop_token& stop);
  void work_on(const Job& job);
  bool only_keys(const LiveWork& work) const;
  std::shared_ptr<const LiveWork> work_of(Studio& studio, const capture::FrameSet& first);
  void tell(Studio& studio, const std::string& problem);
  void publish(const capture::FrameSet& set, recon::LiveFrame&& frame);
  void fail(const std::string& why);

  const MakeWork make_work_;
  const Onlooker onlooker_;
  const std::size_t count_;  // of workers
  capture::BoundedQueue<Job> queue_{1};
  mutable std::mutex mutex_;  // of what follows
  mutable std::condition_variable changed_;
  std::shared_ptr<Studio> studio_;
  std::shared_ptr<const LivePacket> newest_;
  capture::Timestamp newest_time_;  // the moment that it shows
  std::uint64_t sequence_ = 0;      // of the newest
  std::uint32_t viewers_ = 0, picture_viewers_ = 0;
  std::string logged_;                 // the last problem, so that each is logged once
  LiveSurfacesStatus told_;            // counts and triangles
  std::deque<Made> lately_;            // of the last seconds
  Clock::time_point offered_;          // the last set
  std::vector<std::jthread> workers_;  // last
};

// One viewer's place, from any one thread.
class LiveViewer {
 public:
  LiveViewer(LiveSurfaces& surfaces, bool with_pictures);
  ~LiveViewer();
  LiveViewer(const LiveViewer&) = delete;
  LiveViewer& operator=(const LiveViewer&) = delete;

  // The newest surface that it was not handed yet, waiting so long for one.
  std::shared_ptr<const LivePacket> next(std::chrono::milliseconds patience);

 private:
  LiveSurfaces& surfaces_;
  const bool with_pictures_;
  std::uint64_t seen_ = 0;
};

// What the daemon has its surfaces made with: the rig's calibration and volume, the plates in `plates`.
LiveWork live_work(const config::RigConfig& rig, const std::filesystem::path& plates,
                   const std::vector<capture::CameraId>& cameras, const capture::FrameSet& first);

}  // namespace rotunda::rig
