#pragma once
// Groups the frames of many cameras into FrameSets, one a trigger, by each frame's time on the trigger grid.
// Sets leave in trigger order, every trigger of the take exactly once: when no camera is waited for any more, or at the
// deadline with holes that say why.
// Pure logic: no threads, no clock; the caller brings `now`. Use it from one thread at a time.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame.h"
#include "capture/sync/exposure_ledger.h"
#include "capture/sync/trigger_grid.h"

namespace rotunda::capture {

struct AssemblerOptions {
  std::vector<CameraId> cameras;  // the slots of every set, in this order
  TriggerGrid grid;
  std::optional<std::uint64_t> triggers;  // the take's triggers are 0 .. this - 1; nothing: until finish()
  std::chrono::nanoseconds deadline{};    // a set is closed this long after its trigger's moment
  // A frame further than this from its trigger is none of ours; nothing: half a period.
  std::optional<std::chrono::nanoseconds> tolerance;
};

// Every frame handed in is counted once: in_sets, late, duplicate or off_grid, or it still waits for its set.
struct AssemblerCameraCounts {
  std::uint64_t in_sets = 0;    // frames that left in a set
  std::uint64_t late = 0;       // came after their set had gone
  std::uint64_t duplicate = 0;  // a second frame for one trigger
  std::uint64_t off_grid = 0;   // near no trigger of the take, or from the future
  std::uint64_t missing = 0;    // holes of any kind
  std::map<HoleReason, std::uint64_t> missing_because;
  std::uint64_t missing_in_a_row = 0;  // holes since the last frame: a silent camera shows here first
};

struct AssemblerCounts {
  std::uint64_t complete = 0;
  std::uint64_t incomplete = 0;
  std::vector<AssemblerCameraCounts> cameras;  // as in the options
};

class FrameSetAssembler {
 public:
  // Throws InvalidInput without cameras, with two of one name, a period or deadline that is not positive.
  explicit FrameSetAssembler(AssemblerOptions options);

  // Each returns the sets that can leave now, oldest first. A camera that is no slot of the rig is InvalidInput.
  std::vector<FrameSet> add(Frame frame, Timestamp now);
  // A frame that came incomplete. Without its time it cannot be placed: its hole says why only if the camera counts its
  // exposures.
  std::vector<FrameSet> add_loss(const CameraId& camera, std::optional<Timestamp> exposure_start, Timestamp now,
                                 HoleReason because = HoleReason::packets_lost);
  // No frame is waited for from an absent camera (frames that come all the same are taken).
  std::vector<FrameSet> set_absent(const CameraId& camera, bool absent, Timestamp now);
  // Nothing comes of it though it should: its holes that nothing else explains are of a lost camera.
  void set_silent(const CameraId& camera, bool silent) { silent_[slot_of(camera)] = silent; }
  std::vector<FrameSet> advance(Timestamp now);
  // The grid is known better now: every trigger keeps its number. The new one must lie within half a period of the old
  // for the triggers that are still open.
  void set_grid(const TriggerGrid& grid) { options_.grid = grid; }
  // Closes every set that is left, up to the take's last trigger, or the last one begun when no count was given.
  std::vector<FrameSet> finish();

  // When advance() has something to do next; nothing after the last trigger.
  std::optional<Timestamp> next_deadline() const;
  std::uint64_t next_trigger() const { return next_; }
  bool done() const { return options_.triggers && next_ >= *options_.triggers; }
  const AssemblerCounts& counts() const { return counts_; }

 private:
  struct Slot {
    std::optional<Frame> frame;
    std::optional<HoleReason> lost;  // a frame was announced that did not come, or not whole
  };
  using Pending = std::vector<Slot>;

  std::size_t slot_of(const CameraId& camera) const;
  std::optional<std::uint64_t> trigger_of(Timestamp exposure_start, Timestamp now) const;
  Pending& pending(std::uint64_t trigger);
  bool waits_for_nobody(const Pending& set) const;
  FrameSet close_next();
  FrameSlot fill(std::size_t camera, Slot slot);
  HoleReason why_nothing_came(std::size_t camera) const;
  std::vector<FrameSet> collect(std::optional<Timestamp> now);

  AssemblerOptions options_;
  std::chrono::nanoseconds tolerance_{};
  std::vector<bool> absent_, silent_;
  std::vector<ExposureLedger> ledgers_;
  std::map<std::uint64_t, Pending> pending_;
  std::uint64_t next_ = 0;  // trigger of the next set to leave
  AssemblerCounts counts_;
};

}  // namespace rotunda::capture
