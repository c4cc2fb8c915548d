#pragma once
// Normal equations of a pose against silhouettes: every row is how far a rim point and an outline point are apart
// across the outline, and its derivative by the pose's tangent (twists of the joints, Bregler, Malik 1998) and by the
// template's measures. Metres, radians, world.
#include <Eigen/Core>
#include <vector>

#include "capture/camera_model.h"
#include "recon/body/silhouette_outline.h"
#include "recon/body/template_rim.h"

namespace rotunda::recon {

// One camera that sees the frame.
struct OutlineView {
  capture::CameraModel camera;
  SilhouetteOutline outline;
};
using FrameOutlines = std::vector<OutlineView>;

// The tangent of a pose: the root's way along x, y, z, then for every joint the turns it can make.
struct Twist {
  BodyJoint joint = BodyJoint::pelvis;
  enum class Kind : std::uint8_t { translation, own_axis, parent_axis } kind = Kind::own_axis;
  Eigen::Vector3d axis;  // unit: world's, the joint's own, or its parent's
};
const std::vector<Twist>& pose_twists();
// Those that move a joint's frame.
const std::vector<std::uint16_t>& twists_of(BodyJoint joint);
Pose moved(const Pose& pose, const Eigen::VectorXd& step);  // step: an entry a twist

// How the template's joints and vertices change with its measures.
struct MeasureDerivatives {
  std::array<std::array<Eigen::Vector3d, kBodyJoints>, kBodyMeasures> offset;
  std::array<std::vector<Eigen::Vector3d>, kBodyMeasures> vertex;  // as PosedVertices are ordered, each from its joint
};
MeasureDerivatives measure_derivatives(const BodyTemplate& body);

struct NormalEquations {
  Eigen::MatrixXd H;  // lower half
  Eigen::VectorXd g;  // of the half squares: the step is -H^-1 g
  double cost = 0.0;
  void add(const std::vector<std::uint16_t>& columns, const double* values, double residual, double weight);
};

// How well a rim and an outline agree, both ways.
struct OutlineAgreement {
  std::size_t outline_points = 0, explained = 0;  // within 4 cm of the rim
  std::size_t rim_points = 0, on_outline = 0;
  double sum = 0.0;  // of squared distances cut at 10 cm, both ways
  std::array<std::size_t, kBodySegments> segment_rim{}, segment_on_outline{};
  OutlineAgreement& operator+=(const OutlineAgreement& other);
  double rms() const;
  double share() const;  // of both kinds of points that have their partner; 0 without any
};

struct SilhouetteTermOptions {
  double robust_scale = 0.05;  // metres (Geman, McClure 1987)
  double sigma = 0.012;        // of an outline against a template, metres
  double correlation = 8.0;    // neighbouring points err alike: so many count as one
  double spacing_px = 6.0;     // between rim points
};

// Adds all views' rows; with `measures`, columns for the measures follow those of the twists.
OutlineAgreement add_silhouettes(NormalEquations& equations, const BodyTemplate& body, const Pose& pose,
                                 const FrameOutlines& frame, const SilhouetteTermOptions& options,
                                 const MeasureDerivatives* measures = nullptr);

// Without derivatives.
OutlineAgreement agreement(const BodyTemplate& body, const Pose& pose, const FrameOutlines& frame);

}  // namespace rotunda::recon
