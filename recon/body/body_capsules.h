#pragma once
// Limbs do not pass through the trunk or each other: capsules along the bones, pushed apart where they overlap.
#include "recon/body/pose_equations.h"

namespace rotunda::recon {

// Adds a row a pair of capsules that overlap by more than flesh gives way.
void add_capsules(NormalEquations& equations, const BodyTemplate& body, const Pose& pose);

}  // namespace rotunda::recon
