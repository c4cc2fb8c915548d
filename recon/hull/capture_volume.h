#pragma once
// Where to look for the performer when the rig names no volume: what the frusta and the silhouettes leave, found by a
// coarse search around the point the cameras look at. Any unit; world frame.
#include <Eigen/Geometry>
#include <span>
#include <string>

#include "recon/hull/silhouette_view.h"

namespace rotunda::recon {

// A box around the largest solid the silhouettes leave, with a margin. Throws InvalidInput, naming the cameras whose
// silhouettes are empty, if nothing is left.
Eigen::AlignedBox3d capture_volume(std::span<const SilhouetteView> views);

inline constexpr double kPersonCell = 0.010;  // metres

// kPersonCell where `unit` is "m" and the box could be a person's (0.3 to 30 m across), else a 200th of its diagonal.
double default_cell_size(const Eigen::AlignedBox3d& bounds, const std::string& unit);

}  // namespace rotunda::recon
