#pragma once
// Follows a person from frame to frame: predicts, fits, and where the silhouettes disagree tries several other poses
// (the last one, sides swapped, turned round, poses seen before, standing) and keeps the best; now and then it looks
// whether an arm or the legs are held otherwise. World, metres.
#include <optional>
#include <vector>

#include "recon/body/body_start.h"
#include "recon/body/pose_fit.h"

namespace rotunda::recon {

struct TrackerOptions {
  bool only_overlap = false;  // the paper's: silhouette overlap alone, from the last pose, no second thoughts
  bool hurried = false;       // live: second thoughts end with the first that is credible; late frames are worse ones
};

enum class TrackState : std::uint8_t { tracked, recovered, lost };
struct TrackedPose {
  PoseFit fit;
  TrackState state = TrackState::tracked;
  // Of lost frames: why, e.g. "2 of 10 silhouettes show anybody"; the pose is the last good one, its confidence 0.
  std::string loss;
};

class BodyTracker {
 public:
  // From a pose known to fit; `typical_residual` is what it left.
  BodyTracker(BodyTemplate body, const PoseFit& start, const TrackerOptions& options);
  // The next frame, in either direction of time, so many frame times after the last one that was tracked.
  TrackedPose track(const FrameOutlines& frame, double elapsed = 1.0);

 private:
  PoseFit fit(const FrameOutlines& frame, const Pose& start, double first_scale, bool expect) const;
  bool is_doubtful(const PoseFit& fit) const;
  void try_others(const FrameOutlines& frame, PoseFit& best) const;
  void try_starts(const FrameOutlines& frame, const std::vector<Pose>& starts, PoseFit& best) const;
  std::vector<Pose> other_starts(const PoseFit& best) const;
  // True: one of the starts led to what fits better.
  bool try_limbs(const FrameOutlines& frame, const std::vector<Pose>& starts, PoseFit& best) const;
  bool try_legs(const FrameOutlines& frame, PoseFit& best) const;
  Pose predicted(double elapsed) const;
  void remember(const PoseFit& fit);

  BodyTemplate body_;
  TrackerOptions options_;
  Pose last_;
  std::optional<Pose> before_last_;
  double last_elapsed_ = 1.0;      // from that to the last
  std::vector<double> residuals_;  // of the last good frames
  std::vector<Pose> seen_;         // unlike poses that fitted well
  std::size_t frames_ = 0, lost_ = 0;
};

}  // namespace rotunda::recon
