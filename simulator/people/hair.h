#pragma once
// Hair as a solid about the reference head (HeadFrame): a layer on the scalp that begins at the hairline, and what
// hangs from it. Metres.
#include <Eigen/Core>

#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

// Signed distance, negative inside, to first order near the surface. `q` on the reference head.
double hair_distance(const BodyBuild& build, const Eigen::Vector3d& q);

// 0 on bare skin, 1 where hair grows: the hairline, for its colour.
double hair_cover(const BodyBuild& build, const Eigen::Vector3d& q);

}  // namespace rotunda::simulator
