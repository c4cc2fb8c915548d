#pragma once
// Looks at the newest picture of each camera about twice a second, in a thread of its own that never takes more than a
// twentieth of a core: whoever has frame sets offers them, and nothing ever waits for it.
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "capture/frame.h"
#include "capture/picture_health.h"

namespace rotunda::rig {

class PictureWatch {
 public:
  PictureWatch();

  // Keeps the set's frames until they were looked at, if it is time to look again. Never blocks.
  void offer(const capture::FrameSet& set);
  // Of the camera's newest picture; nothing while none came for a few seconds.
  std::optional<capture::PictureHealth> health(const capture::CameraId& camera) const;
  // That picture itself, small, if it was looked at since `asked`; else empty.
  cv::Mat portrait(const capture::CameraId& camera, std::chrono::steady_clock::time_point asked) const;

 private:
  struct Look {
    capture::PictureHealth health;
    cv::Mat portrait;
    std::chrono::steady_clock::time_point at;
  };

  void run(std::stop_token stop);
  void look_at(const capture::FrameSlot& slot);

  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  std::chrono::steady_clock::time_point next_look_;
  std::optional<capture::FrameSet> newest_;
  std::map<capture::CameraId, Look> looks_;
  std::jthread thread_;  // last
};

}  // namespace rotunda::rig
