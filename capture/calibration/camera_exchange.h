#pragma once
// Two cameras that changed names, plugs or folders: against a calibration from before, or while the board was shown.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>

#include "capture/calibration/camera_graph.h"

namespace rotunda::capture {

// Of two sets of camera centres (metres, a column each) the two cameras that must change places in `then` for it to be
// `now`, moved rigidly. Nothing if it is already, if no two do, or of fewer than four cameras.
std::optional<std::pair<Eigen::Index, Eigen::Index>> exchanged_centres(const Eigen::Matrix3Xd& now,
                                                                       const Eigen::Matrix3Xd& then);

struct Exchange {
  std::size_t a = 0, b = 0;     // of `cameras`
  std::size_t first_after = 0;  // moment from which each shows what the other showed before
};
// `graph`: as place_cameras made it of the same. Where two cameras or more see boards elsewhere, the rig is placed by
// the earlier and by the later boards alone, and the two are compared.
std::optional<Exchange> find_exchange(const CameraGraph& graph, std::span<const CameraModel> cameras,
                                      std::span<const Sighting> sightings, std::span<const Board> boards);

// "cam00 and cam01 were swapped by m24: ...".
std::string in_words(const Exchange& exchange, std::span<const CameraModel> cameras,
                     std::span<const std::string> moments);

}  // namespace rotunda::capture
