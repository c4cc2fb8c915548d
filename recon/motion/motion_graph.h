#pragma once
// Motion graph (Kovar, Gleicher, Pighin 2002; Starck, Miller, Hilton 2005, 5.1; ALGORITHMS step 9): states that go on
// as cycles, transitions between them, each made of clips laid end to end. Where one clip takes over from another the
// two are blended linearly over a few frames, the second laid over the first on the floor. Nothing is baked: a seam is
// where it lies and how the clips lie there. Clips correspond sample by sample and travel over a floor that stands.
// Metres, seconds, radians; frames are the clip's, from 0.
#include <optional>
#include <string>
#include <vector>

#include "recon/motion/floor_pose.h"
#include "recon/motion/gait_events.h"

namespace rotunda::recon {

inline constexpr int kBlendFrames = 5;  // of the paper

// What a seam costs, over its blended frames.
struct SeamPrice {
  double error_mm = 0.0;    // between the two surfaces, root mean square
  double largest_mm = 0.0;  // between two samples
  double step_ratio = 0.0;  // largest step of a sample, frame to frame, against the median of that in both clips
  double colour = 0.0;      // between the two surfaces' colours, root mean square, of 255
  double slide_mm = 0.0;    // of the standing foot
};

// From frame `leave` of one clip on, another is blended in, from its frame `enter` on.
struct Join {
  int leave = 0, enter = 0;
  int blend = kBlendFrames;
  FloorPose pose;  // leaving_from_entering: lays the second clip over the first
  SeamPrice price;
};

struct MotionClip {
  std::string name;
  std::string take;  // where it comes from, for people
  int frames = 0;
  double heading = 0.0;  // in the clip's own floor
  double speed = 0.0;    // m/s
  std::vector<HeelStrike> strikes;
  std::vector<FootContact> contacts;
};

// A cycle: plays its clip, and at loop.leave goes over to loop.enter of the same.
struct MotionState {
  std::string name;
  std::string clip;
  Join loop;  // enter < leave

  int period() const { return loop.leave - loop.enter; }
};

struct MotionTransition {
  std::string name;
  std::string from, to;      // states; an action begins and ends in the same one
  std::string clip;          // empty: synthesised, from state to state directly
  std::vector<Join> leaves;  // out of `from`, into the clip or, synthesised, into `to`; ordered by leave
  Join arrive;               // out of the clip into `to`; not of synthesised ones

  bool synthesised() const { return clip.empty(); }
};

struct MotionGraph {
  std::string name;
  double fps = 25.0;
  std::string start;  // state
  std::vector<MotionClip> clips;
  std::vector<MotionState> states;
  std::vector<MotionTransition> transitions;

  // Throw InvalidInput with the names that are there.
  const MotionClip& clip(const std::string& wanted) const;
  const MotionState& state(const std::string& wanted) const;
  const MotionTransition* next_towards(const std::string& from, const std::string& to) const;  // null: no way
};

// The weight of what is blended in at blended frame k = 0, 1, ... of n: 1/(n+1), 2/(n+1), ...
inline double blend_weight(double k, int n) {
  return std::min(1.0, std::max(0.0, (k + 1.0) / (n + 1.0)));
}

}  // namespace rotunda::recon
