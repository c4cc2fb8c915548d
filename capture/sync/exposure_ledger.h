#pragma once
// Why a camera has no frame at a trigger, told from the camera's own count of exposures: between two frames whose
// triggers are known it either exposed as often as it was triggered (then what is missing was lost on the way) or less
// often (then it missed the trigger). Frames that came and belong to no trigger (doubled triggers) are taken off first.
#include <cstdint>
#include <optional>
#include <set>

#include "capture/frame.h"

namespace rotunda::capture {

class ExposureLedger {
 public:
  struct Place {
    std::uint64_t trigger = 0;
    std::uint64_t id = 0;  // Frame::id
  };

  // Every frame that came, whether it found a place or not.
  void came(std::uint64_t id);
  // The set of the next trigger left with this camera's frame ...
  void left_with(const Frame& frame);
  // ... or with a hole; `announced`: the camera's stream told of a frame that was lost.
  void left_without(bool announced);

  // Why there is nothing at a trigger between the last frame that left and `next`, the first that waits after it.
  // `announced` of the triggers between that have not left yet are known to be lost. Late: cannot be told.
  HoleReason reason(const std::optional<Place>& next, std::uint64_t announced) const;

 private:
  std::optional<Place> last_;
  std::uint64_t announced_ = 0;  // holes since then that were told of
  std::set<std::uint64_t> came_;
};

}  // namespace rotunda::capture
