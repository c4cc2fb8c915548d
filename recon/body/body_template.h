#pragma once
// The template that motion capture fits to a person (de Aguiar, Zayer, Theobalt, Magnor, Seidel 2007, 5.1; Carranza et
// al. 2003): a Skeleton and sixteen closed surface segments, made from thirty lengths and widths. Left and right are
// alike. Metres; rest pose and frames as recon/body/skeleton.h has them.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "recon/body/pose.h"
#include "recon/body/skeleton.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

enum class BodyMeasure : std::uint8_t {
  // lengths between joints
  trunk,      // hip joints to the line of the shoulder joints
  neck,       // joint of the neck (C7/T1) to that of the head (the skull's base)
  head,       // joint of the head to the crown
  shoulders,  // between the shoulder joints
  hips,       // between the hip joints
  upper_arm,
  forearm,
  hand,  // wrist to fingertips
  thigh,
  shank,
  foot,         // ankle to the tip of the toes
  foot_height,  // ankle above the sole
  // full widths of the surface
  pelvis_breadth,
  pelvis_depth,
  waist_breadth,
  waist_depth,
  chest_breadth,
  chest_depth,
  neck_width,
  head_breadth,
  head_depth,
  upper_arm_width,
  elbow_width,
  wrist_width,
  hand_width,
  thigh_width,
  knee_width,
  calf_width,
  ankle_width,
  foot_width,
};
inline constexpr std::size_t kBodyMeasures = 30;
std::string_view to_string(BodyMeasure measure);

using BodyMeasures = std::array<double, kBodyMeasures>;  // metres
constexpr std::size_t index(BodyMeasure measure) {
  return static_cast<std::size_t>(measure);
}

// An adult of a height (metres): lengths after Drillis and Contini (1966) as Winter prints them, widths from the means
// of both sexes in ANSUR II (Gordon et al. 2014).
BodyMeasures measures_of_height(double height);
double height_of(const BodyMeasures& measures);       // standing straight, sole to crown
double root_height_of(const BodyMeasures& measures);  // then of the pelvis joint above the soles

inline constexpr std::size_t kBodySegments = 16;
// The joint that carries a segment: pelvis, spine (abdomen), chest, neck (neck and head), arms and legs.
BodyJoint joint_of_segment(std::size_t segment);

// A closed tube of elliptic rings; its vertices from its joint, at rest.
struct BodySegmentSurface {
  std::vector<Eigen::Vector3d> vertices;
};
// Of any segment; all have the same. Counter-clockwise seen from outside.
const std::vector<std::array<std::uint32_t, 3>>& segment_triangles();
std::size_t vertices_of_segment();

struct BodyTemplate {
  BodyMeasures measures;
  Skeleton skeleton;
  std::array<BodySegmentSurface, kBodySegments> segments;
};

// Throws InvalidInput for a measure that is not positive and finite.
BodyTemplate make_template(const BodyMeasures& measures);
inline BodyTemplate template_of_height(double height) {
  return make_template(measures_of_height(height));
}

// All segments as they stand in the pose, one after another, world, with normals: segment i has the vertices
// [i, i + 1) * vertices_of_segment() and the triangles [i, i + 1) * segment_triangles().size().
TriangleMesh pose_template(const BodyTemplate& body, const Pose& pose);
std::vector<std::uint8_t> triangle_segments();  // the segment of each of its triangles

}  // namespace rotunda::recon
