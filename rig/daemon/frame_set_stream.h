#pragma once
// Frame sets as they come: has the triggers fired and groups what the cameras send. What becomes of the sets (a take, a
// look at the pictures) is the sink's business. Camera threads only hand frames in.
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "capture/sync/frame_set_assembler.h"
#include "capture/sync/silence_watch.h"
#include "capture/sync/sync_statistics.h"
#include "config/rig_config.h"
#include "rig/daemon/camera_fleet.h"
#include "rig/daemon/take_trigger.h"

namespace rotunda::rig {

struct FrameSetStreamOptions {
  config::TriggerConfig trigger;
  std::optional<std::uint64_t> wanted;     // triggers; nothing: until stopped
  std::vector<capture::CameraId> cameras;  // the slots of every set; frames of others are let go
  std::chrono::nanoseconds deadline{};     // a set goes without its missing frames this long after its trigger
};

// Is shown every set of a session, with the cameras of its slots; must only pass it on.
using Onlooker = std::function<void(const capture::FrameSet&, const std::vector<capture::CameraId>&)>;

class FrameSetStream : public FrameReceiver {
 public:
  // Every trigger's set once, in order; from whichever thread closes it, one at a time. It must only pass sets on.
  using Sink = std::function<void(capture::FrameSet&&)>;

  // Takes hold of the trigger. Throws DeviceError (no camera streams, no box, no link to the cameras).
  FrameSetStream(FrameSetStreamOptions options, CameraFleet& fleet);
  ~FrameSetStream() override;  // no frame is taken any more

  void start(Sink sink);  // the first trigger comes soon after; once
  void stop();            // no further triggers; sets of those before still come
  // Sets of triggers that were fired leave with what they have: nothing more will come. After stop().
  void abandon();
  // None of the cameras sends frames or answers.
  bool all_gone() const;
  // What happened with cameras since the last call: "cam03 sends no pictures any more", "cam03 is back".
  std::vector<std::string> take_incidents();
  // Lets go sets whose deadline has passed. True while there are more to come. Call it every few tens of milliseconds.
  bool advance();

  const std::vector<capture::CameraId>& cameras() const { return cameras_; }
  std::optional<std::uint64_t> wanted() const { return trigger_->wanted(); }
  std::uint64_t late_triggers() const;
  std::uint64_t late_frames() const;
  capture::AssemblerCounts counts() const;
  capture::SyncSummary sync() const;
  std::string failure() const { return trigger_->failure(); }
  std::vector<std::string> warnings() const { return trigger_->warnings(); }

 private:
  void take_frame(capture::Frame&& frame) override;
  void take_incomplete(const capture::IncompleteFrame& incomplete) override;
  bool is_slot(const capture::CameraId& camera) const;
  void move_grid(const capture::TriggerGrid& grid);
  bool let_go_what_is_due(std::optional<std::uint64_t> triggers_in_all);
  capture::Timestamp due_until(capture::Timestamp now, std::optional<std::uint64_t> triggers) const;
  void hear(const capture::CameraId& camera, capture::Timestamp now);
  void end_silence();
  void look_for_silence(capture::Timestamp now);
  std::size_t slot_of(const capture::CameraId& camera) const;
  void pass_on(std::vector<capture::FrameSet> sets);
  std::optional<std::uint64_t> triggers_in_all() const;

  CameraFleet& fleet_;
  std::vector<capture::CameraId> cameras_;
  std::chrono::nanoseconds deadline_;
  std::unique_ptr<TakeTrigger> trigger_;
  Sink sink_;
  mutable std::mutex mutex_;  // of what follows
  capture::TriggerGrid grid_;
  capture::FrameSetAssembler assembler_;
  capture::SyncStatistics sync_;
  capture::SilenceWatch silence_;
  std::vector<std::string> incidents_;
  bool abandoned_ = false;
};

}  // namespace rotunda::rig
