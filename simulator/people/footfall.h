#pragma once
// When the heels of somebody come down, seen in how high they are: for motions that nobody planned. A heel strikes
// where, having been lifted, it comes back to the height at which it mostly stands, and is as low as it then gets. Feet
// that are dragged, and a foot that lands on its ball and keeps the heel up, give none. Metres, seconds.
#include <array>
#include <functional>
#include <vector>

#include "simulator/people/gait.h"

namespace rotunda::simulator {

struct FootfallOptions {
  double duration = 0.0;
  bool is_cyclic = false;       // its end is its beginning
  double person_height = 1.75;  // distances are in proportion
  double step = 0.005;  // seconds between looks; what is known at longer intervals need not be looked at oftener
};

// `heights_at`: of the left and the right heel over the floor, for seconds in [0, duration]. In order, in [0,
// duration).
std::vector<HeelStrike> find_heel_strikes(const std::function<std::array<double, 2>(double seconds)>& heights_at,
                                          const FootfallOptions& options);

}  // namespace rotunda::simulator
