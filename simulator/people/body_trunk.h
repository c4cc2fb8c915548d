#pragma once
// The trunk from the crotch to the neck as a stack of rounded cross-sections. Frame: the person's, scaled to a height
// of 1.75 m; metres.
#include <Eigen/Core>

#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

// Signed distance, to first order near the surface; `ease`: how far cloth stands off there.
double trunk_distance(const BodyBuild& build, const Eigen::Vector3d& q, double ease);

}  // namespace rotunda::simulator
