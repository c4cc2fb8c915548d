#pragma once
// Private to recon/sphere: where spherical matching begins.
#include <Eigen/Core>

#include "recon/sphere/spherical_matching.h"

namespace rotunda::recon {

// The rotation of S that costs least (eq. (4) for the W that suits it): 1320 of them spread evenly, about 20 degrees
// apart, the best four made finer to a degree. Pure; the same on any number of threads.
Eigen::Matrix3d least_cost_rotation(const GeometryImage& from, const GeometryImage& to, const MatchingOptions& options);

}  // namespace rotunda::recon
