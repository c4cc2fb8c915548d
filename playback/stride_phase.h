#pragma once
// Where in its stride a cycle is, told by its heel strikes, so that two cycles of one person can be played as one, at a
// speed between theirs (Rose, Cohen, Bodenheimer 1998; Heck, Gleicher 2007). Phase 0 is the left heel's strike, 1/2 the
// right one's, linear between. Frames are the clip's, metres, seconds.
#include <optional>

#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

struct StridePhase {
  double enter = 0.0, period = 1.0;  // of the cycle, frames
  double left = 0.0, right = 0.0;    // strikes, frames after `enter`, less than a period

  double phase_at(double frame) const;  // 0 to 1
  double frame_at(double phase) const;  // enter to enter + period
};

// Nothing of who does not go, or strikes with one foot only.
std::optional<StridePhase> stride_phase(const recon::MotionGraph& graph, const recon::MotionState& state);

// The share of the faster cycle at which a stride's length over its time is the speed asked for. Speeds beyond the two
// give 0 and 1.
struct StridePace {
  double seconds = 1.0;  // a stride
  double speed = 0.0;    // m/s
};
double share_for(double speed, const StridePace& slow, const StridePace& fast);

}  // namespace rotunda::playback
