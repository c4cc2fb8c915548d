#pragma once
// Other ways the arms may be held than a fit has it: a forearm in front of the trunk shows in few silhouettes, and from
// where it went wrong no small step leads back. Starts for further fits. World, metres.
#include <vector>

#include "recon/body/pose.h"

namespace rotunda::recon {

// One arm changed at a time: the elbow a little and well bent, its forearm to four sides; and as the other arm is held.
std::vector<Pose> other_arms(const Pose& pose);

}  // namespace rotunda::recon
