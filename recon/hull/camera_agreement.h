#pragma once
// Has a camera moved since it was calibrated? By the performer's outlines alone, as a studio with plain walls shows
// nothing else. A plane through two cameras' centres that touches the body touches both silhouettes: the tangents from
// an epipole to one outline are those from the other camera's to its own (epipolar tangency, frontier points: Cipolla,
// Astrom, Giblin 1995; used to calibrate from silhouettes by Sinha, Pollefeys, McMillan 2004). A camera that was turned
// disagrees with all others alike, over all frames; how its picture must be moved to agree again is found robustly.
// Any unit; mirrored worlds as well. Pure; the same on any number of threads.
#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "recon/hull/convex_outline.h"

namespace rotunda::recon {

// A camera's outline at each frame; none where it has no picture.
using OutlinesOverTime = std::vector<ConvexOutline>;

struct CameraShift {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // R now = exp([turn]x) R of the calibration; radians, camera frame
  Eigen::Vector2d at_middle{0.0, 0.0};             // pixels that the middle of its picture has moved
  double roll_deg = 0.0;                           // about the line of sight, clockwise in the picture
  double shift_px = 0.0;                           // mean where the performer is
  double deviation_px = 0.0;                       // standard deviation of that
  double clearness = 0.0;                          // of the turn: in standard deviations of all three axes together
  int tangents = 0;                                // that agree with each other
  bool still = false;                              // the performer hardly moves: ten pixels at least are told
  bool moved = false;                              // by more than calibration and mattes leave open
};

// One a camera; nothing where it cannot be told: too few frames with its whole outline, or too few other cameras.
// Throws InvalidInput if the spans differ in size.
std::vector<std::optional<CameraShift>> camera_shifts(std::span<const capture::CameraModel> cameras,
                                                      std::span<const OutlinesOverTime> outlines);

// The camera as it stands now.
capture::CameraModel turned(capture::CameraModel camera, const CameraShift& shift);

}  // namespace rotunda::recon
