#pragma once
// Clean-up across views: what the other cameras cannot support is not the performer. A piece of a matte stays only if
// somewhere along its rays is a point that the other views' silhouettes hold too, a stray one of them excepted: one
// camera's lost arm must not cost the others theirs. Outside of a view's picture is unknown to it, not empty.
// World frame and the calibration's unit. Pure; the same on any number of threads.
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"
#include "recon/hull/silhouette_view.h"

namespace rotunda::recon {

struct MatteSupportOptions {
  std::optional<Eigen::AlignedBox3d> bounds;  // the rig's volume; searched for if not given
  double cube_size = 0.0;                     // of the search, world units; 0: three times the hull's cell
  std::string unit = "m";                     // of the calibration
  int stray_views = 1;                        // so many may deny a point and it still supports the others
  std::vector<bool> keep;                     // a slot a matte: it stays whatever the others say; empty: none does
};

struct SupportedMattes {
  std::vector<capture::Matte> mattes;
  std::vector<SilhouetteView> views;  // of these mattes
  std::vector<double> dropped;        // of each matte, the share of its area that no other view supports, 0 to 1
  // Views that would have lost more than a quarter: then the views disagree (a moved camera, a failed key), and a vote
  // decides nothing. Those keep their matte as it was.
  std::vector<std::size_t> disagreeing;
};

// Fewer than four views with a silhouette change nothing: two are too few to outvote one. Throws InvalidInput if the
// spans differ in size or a matte is not of its camera's.
SupportedMattes supported_mattes(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                                 const MatteSupportOptions& options = {});

}  // namespace rotunda::recon
