#pragma once
// The planes through two cameras' centres that touch a silhouette (epipolar tangency: what touches the body is seen as
// a tangent by both, Cipolla, Astrom, Giblin 1995). World frame, any unit; mirrored worlds as well.
#include <Eigen/Core>
#include <optional>

#include "capture/camera_model.h"
#include "recon/hull/convex_outline.h"

namespace rotunda::recon {

// Those planes as an angle about the line between the centres, radians, counted from u towards v.
struct Pencil {
  Eigen::Vector3d u, v;  // unit vectors across the line, world
};

// Counted from `towards`, a direction not along the line. The centres must differ.
Pencil pencil_of(const capture::CameraModel& a, const capture::CameraModel& b, const Eigen::Vector3d& towards);

// A plane that touches an outline, and what its angle changes by.
struct Tangent {
  double angle = 0.0;
  Eigen::Vector2d at{0.0, 0.0};                        // where it touches, ideal image plane
  double per_pixel = 0.0;                              // that the touching point moves across the tangent
  Eigen::Vector3d per_turn = Eigen::Vector3d::Zero();  // of the camera, in its own frame
};
struct Tangents {
  Tangent lowest, highest;
};

// Nothing where the epipole lies in the outline or just beside it.
std::optional<Tangents> tangents(const capture::CameraModel& camera, const ConvexOutline& outline,
                                 const Pencil& pencil);

// Pixels a unit of the ideal image plane, the mean of both axes.
double focal_px(const capture::CameraModel& camera);

}  // namespace rotunda::recon
