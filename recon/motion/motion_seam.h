#pragma once
// Where clips go over into each other, and what that costs (ALGORITHMS step 9): cycles within a clip, transitions
// between two. Candidates are windows of as many frames as are blended, laid over each other as rigid wholes, so speeds
// must agree as well as shapes; what heel strikes there are meet. Clips correspond, and travel over a standing floor.
#include <optional>
#include <string>
#include <vector>

#include "recon/motion/clip_shape.h"
#include "recon/motion/frame_similarity.h"
#include "recon/motion/gait_events.h"
#include "recon/motion/motion_graph.h"

namespace rotunda::recon {

// A clip with all that seams are judged by.
struct MovingClip {
  ClipShape shape;
  GaitEvents events;
  double median_step = 0.0;  // median over the frames of the largest step of a sample, metres
};
MovingClip moving_clip(ClipShape shape);  // finds the events and lets the clip travel

// The largest way of any sample from one frame to the next, metres.
double largest_step(const std::vector<Eigen::Vector3f>& from, const std::vector<Eigen::Vector3f>& to);

struct CycleSearch {
  std::optional<Join> loop;
  std::string failure;  // why there is none, and what to do
};
// Of people who stand the blend is longer if the seam else stood out.
CycleSearch find_cycle(const MovingClip& clip, int blend);

// Out of the frames [first, end) of `from` into those of [enter_first, enter_end) of `to`: for every frame left the
// best one entered, those kept that are not much worse than the best; ordered by leave. Priced.
struct JoinRange {
  int first = 0, end = 0, enter_first = 0, enter_end = 0;
};
std::vector<Join> find_joins(const MovingClip& from, const MovingClip& to, const JoinRange& range, int blend);

// As find_joins, however far the clips are apart.
std::vector<Join> nearest_joins(const MovingClip& from, const MovingClip& to, const JoinRange& range, int blend);

// Of seams that nobody sees (steps of 1.5 of the clips' median largest one, a standing foot that goes 10 mm) the one
// whose surfaces are nearest, else the one that stands out least. There must be one.
const Join& best_seam(const std::vector<Join>& joins);

// The pose that lays `to` over `from` at a seam with the standing foot held, and the price of that.
Join make_join(const MovingClip& from, const MovingClip& to, int leave, int enter, int blend);

// Blended frame k of a seam, in the floor of the clip that is left.
std::vector<Eigen::Vector3f> blended_frame(const MovingClip& from, const MovingClip& to, const Join& join, int k);

}  // namespace rotunda::recon
