#pragma once
// Motion capture while the cameras run: silhouettes come one set after another, the person is found by itself, measured
// after some two dozen frames, followed, and found again after they were lost. World frame, metres.
// Pure: no files, no log, no clock.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "recon/body/body_tracker.h"
#include "recon/live_reconstruction.h"

namespace rotunda::recon {

enum class LiveMotionState : std::uint8_t { searching, tracked, recovered, lost };
std::string_view to_string(LiveMotionState state);

struct LiveMotionFrame {
  LiveMotionState state = LiveMotionState::searching;
  std::string why;                   // searching or lost: what is seen instead of a person
  std::optional<BodyTemplate> body;  // as far as it is measured by now; none while searching
  PoseFit fit;                       // lost: the last good pose, confidence 0
};

class LiveMotion {
 public:
  // The next set's silhouettes, so many seconds after the last ones.
  LiveMotionFrame follow(const FrameOutlines& frame, double seconds = 0.04);

 private:
  LiveMotionFrame search(const FrameOutlines& frame);
  std::optional<BodyStart> start_of(const FrameOutlines& frame);
  void measure(const FrameOutlines& frame, const Pose& pose);

  std::optional<BodyTemplate> body_;
  bool measured_ = false;  // over many frames
  std::unique_ptr<BodyTracker> tracker_;
  std::vector<FrameOutlines> frames_;  // to measure with
  std::vector<Pose> poses_;
  std::vector<BodyStart> starts_;  // that are no good enough by themselves
  int lost_ = 0;                   // frames in a row
};

// Of the mattes that a live surface was made from, at their half size. `cameras`: of the set's slots, full size.
FrameOutlines live_outlines(std::span<const LiveView> views, std::span<const capture::CameraModel> cameras);

}  // namespace rotunda::recon
