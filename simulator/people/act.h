#pragma once
// What a person does. An act is periodic on the 40 ms grid of the simulated studio, so that it can be rendered ahead.
#include <string>
#include <string_view>
#include <vector>

#include "simulator/people/gait.h"

namespace rotunda::simulator {

inline constexpr double kActStep = 0.040;  // seconds between act frames

enum class Act { walk, idle, a_pose };

// "walk", "idle", "a-pose"; throws InvalidInput with the known names for another.
Act act_from(std::string_view name);
std::vector<std::string> act_names();

int act_frames(Act act);  // act frames until it repeats, at least 1
std::vector<HeelStrike> heel_strikes(Act act);

// World pose at a time (any; the act repeats), the person at the origin facing +x.
Pose pose_at(const Skeleton& skeleton, Act act, double seconds);

}  // namespace rotunda::simulator
