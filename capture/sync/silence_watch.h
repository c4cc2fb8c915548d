#pragma once
// Which cameras have fallen silent while triggers are fired: told within two periods and 100 ms (180 ms at 25 Hz) if
// looked for every kLookForSilence, long before their connection is given up (Aravis: 6 s). Anything that comes of a
// camera is a sign of life, whole or not. Pure; the caller brings `now`. One thread at a time.
#include <chrono>
#include <cstddef>
#include <vector>

#include "capture/frame.h"

namespace rotunda::capture {

inline constexpr std::chrono::milliseconds kLookForSilence{20};

class SilenceWatch {
 public:
  // The period of the triggers; throws InvalidInput unless it is positive.
  SilenceWatch(std::size_t cameras, std::chrono::nanoseconds period);

  // Triggers come from then on, and nothing is expected before.
  void begin(Timestamp first_trigger);
  // True if it was silent until now.
  bool heard(std::size_t camera, Timestamp now);
  // Those that have fallen silent since the last look.
  std::vector<std::size_t> look(Timestamp now);
  bool is_silent(std::size_t camera) const { return cameras_.at(camera).silent; }
  // Since its last frame, or since its first should have been there; nothing of one that is not silent.
  std::chrono::nanoseconds silent_for(std::size_t camera, Timestamp now) const;

  std::chrono::nanoseconds patience() const { return patience_; }

 private:
  struct Camera {
    Timestamp heard;
    bool silent = false;
  };
  std::vector<Camera> cameras_;
  std::chrono::nanoseconds patience_;
};

}  // namespace rotunda::capture
