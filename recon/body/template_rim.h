#pragma once
// The rim of a posed BodyTemplate in one camera: where its silhouette ends (the occluding contour). Every segment's
// silhouette is taken as the convex hull of its vertices' pictures (the head's: two, the neck is thinner); what of a
// hull's edge lies inside another segment's is inner and no part of the rim.
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "capture/camera_model.h"
#include "recon/body/body_template.h"

namespace rotunda::recon {

// Vertices of all segments in world, one segment after another.
using PosedVertices = std::vector<Eigen::Vector3d>;
PosedVertices posed_vertices(const BodyTemplate& body, const JointTransforms& transforms);

struct RimPoint {
  Eigen::Vector3d point;       // world: (1 - mix) * vertex a + mix * vertex b
  Eigen::Vector2d pixel;       // where the camera sees it
  Eigen::Vector2d normal;      // in the picture, unit, out of the template
  std::uint32_t a = 0, b = 0;  // into PosedVertices
  double mix = 0.0;
  std::uint8_t segment = 0;
};

// Points about `spacing_px` apart. Segments partly behind the camera are left out.
std::vector<RimPoint> template_rim(const PosedVertices& vertices, const capture::CameraModel& camera,
                                   double spacing_px);

// Change of the pixel with the world point, 2 x 3, without the lens's distortion (per cents, and only of the step).
Eigen::Matrix<double, 2, 3> pixel_jacobian(const capture::CameraModel& camera, const Eigen::Vector3d& point);

}  // namespace rotunda::recon
