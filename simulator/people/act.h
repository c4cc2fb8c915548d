#pragma once
// What a person does: a pose for every moment, on the 40 ms grid of the simulated studio, so that it can be rendered
// ahead. World: metres, z up, the stage's middle at the origin; the person starts facing +x.
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "simulator/people/gait.h"

namespace rotunda::simulator {

inline constexpr double kActStep = 0.040;  // seconds between act frames

struct Motion {
  std::string name;
  int frames = 1;          // act frames until it starts again
  bool is_cyclic = false;  // frame `frames` would be frame 0: it repeats without a jump
  std::vector<HeelStrike> heel_strikes;
  std::function<Pose(double seconds)> pose_at;  // seconds in [0, frames * kActStep]; thread-safe
};

struct MotionOptions {
  bool travel = false;  // walks through the volume instead of on the spot
  std::uint32_t seed = 1;
};

// One of act_names(); throws InvalidInput with the known names for another.
Motion motion_of(std::string_view act, const Skeleton& skeleton, const MotionOptions& options = {});
std::vector<std::string> act_names();

}  // namespace rotunda::simulator
