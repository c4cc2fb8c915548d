#pragma once
// Other ways limbs may be held than a fit has it: a forearm in front of the trunk or legs under a skirt show in few
// silhouettes, and from where they went wrong no small step leads back. Starts for further fits. World, metres.
#include <vector>

#include "recon/body/pose.h"

namespace rotunda::recon {

// One arm changed at a time: the elbow a little and well bent, its forearm to four sides; and as the other arm is held.
std::vector<Pose> other_arms(const Pose& pose);
// One leg changed at a time: the thigh forwards and back, the knee straight and bent.
std::vector<Pose> other_legs(const Pose& pose);
Pose legs_swapped(const Pose& pose);

}  // namespace rotunda::recon
