#pragma once
// Everything at once: intrinsics, distortion, camera poses, board poses and, if asked, the boards' bending, so that the
// corners fall where they were found (Triggs et al. 2000). Priors on what pictures alone hardly tell (principal point,
// higher distortion) are weighed against the corners' noise, which is estimated from the residuals; a robust loss of
// 2.5 times that noise bears wrong corners, which are then left out.
#include <map>
#include <utility>
#include <vector>

#include "capture/calibration/board_detector.h"
#include "capture/camera_model.h"

namespace rotunda::capture {

// One board in one picture, as found. Numbers of cameras, moments and boards are the caller's.
struct Sighting {
  std::size_t camera = 0, moment = 0, board = 0;
  bool predicted = false;  // found by where an earlier calibration put it
  double blur_px = 0.0;
  std::vector<FoundCorner> corners;
};

using BoardKey = std::pair<std::size_t, std::size_t>;  // moment, board

// Sag over a flat board: z = xx x^2 + xy x y + yy y^2, metres, in the board's frame.
struct Bend {
  double xx = 0.0, xy = 0.0, yy = 0.0;  // per metre
};
Eigen::Vector3d bent(const Bend& bend, const Eigen::Vector3d& flat);

struct RigState {
  std::vector<CameraModel> cameras;
  std::map<BoardKey, Eigen::Isometry3d> world_from_board;
  std::vector<Bend> bends;  // one a board
};

struct AdjustmentOptions {
  bool keep_intrinsics = false;  // K and distortion stay as they are
  bool keep_cameras = false;     // also the poses: boards alone are fitted
  bool bend = false;
  int rounds = 8;  // of noise estimate and solution, at most
};

// Standard deviations and what they rest on; of the corners that took part.
struct AdjustmentReport {
  double noise_px = 0.0;  // standard deviation a axis, from the residuals' median
  double cost = 0.0;      // robust, in units of the noise
  bool converged = false;
  std::size_t corners = 0;
};

// Changes `state`. Sightings of boards or cameras that the state does not have are passed over; `world` is held by the
// first camera's pose. Throws InvalidInput if nothing is left to adjust.
AdjustmentReport adjust(RigState& state, std::span<const Sighting> sightings, std::span<const Board> boards,
                        const AdjustmentOptions& options = {});

// Found minus calibrated, pixels; nothing where the state puts the corner behind the camera or outside its lens.
std::optional<Eigen::Vector2d> residual(const RigState& state, const Sighting& sighting, const FoundCorner& corner,
                                        const Eigen::Vector3d& on_board);
// The median of all residuals' components to a standard deviation.
double noise_of(std::vector<double> absolute_components);

// The sightings without the corners that are off by more than `limit` times the noise, and without what then does not
// span an area; `removed` counts the corners.
std::vector<Sighting> without_outliers(const RigState& state, std::span<const Sighting> sightings,
                                       std::span<const Board> boards, double limit_px, std::size_t& removed);

}  // namespace rotunda::capture
