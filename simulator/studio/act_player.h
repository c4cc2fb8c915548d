#pragma once
// Gives each camera what it sees in an exposure, as GigeStudio's PictureAt asks for it: the act frame that the time of
// the exposure says (act_frame_at). Short acts are held in memory, long ones streamed from the frame cache.
#include <cstdint>
#include <functional>
#include <memory>

#include "capture/frame.h"
#include "simulator/studio/frame_cache.h"

namespace rotunda::simulator {

struct PlayerCounts {
  std::uint64_t from_disk = 0;   // pictures read ahead
  std::uint64_t unexpected = 0;  // read when asked for: the first, and after a jump of the trigger
  std::uint64_t late = 0;        // read when asked for although foreseen: the disk falls behind
  std::uint64_t damaged = 0;     // not given
};

class ActPlayer {
 public:
  virtual ~ActPlayer() = default;
  // As the camera sends it; empty if there is none. Valid until the eighth following call for the same camera. From one
  // thread at a time.
  virtual std::span<const std::uint8_t> picture_at(std::size_t camera, capture::Timestamp exposure_start) = 0;
  virtual int frames() const = 0;           // of the act
  virtual PlayerCounts counts() const = 0;  // from any thread
};

std::unique_ptr<ActPlayer> hold_in_memory(std::vector<PictureSet> frames);

// Owns a thread, "prefetch", that reads each camera's next pictures while the ones before are sent: as many act frames
// further each as from the last to this one. It holds 240 MB of them, for ten cameras of 720 x 576 those of the
// next 1.8 seconds; of large cameras at least the next eight. A picture that is not there in time is read when asked
// for and counted; once a second a warning tells.
std::unique_ptr<ActPlayer> stream_from_disk(CacheEntry entry);

}  // namespace rotunda::simulator
