#pragma once
// The other side of a body: where on template and scan the mirrored place of a marked one is, however unlike the arms
// and legs are held. A place is seen from the joint of its segment, mirrored there, and carried by the joint of the
// other side. World frame as the prepared scan, metres.
#include <optional>

#include "recon/deform/scan_preparation.h"
#include "recon/deform/template_fit.h"
#include "recon/track/surface_target.h"

namespace rotunda::recon {

class BodyMirror {
 public:
  // Keeps references to both.
  BodyMirror(const TriangleMesh& scan, const TemplateFit& fit);

  // The template's triangle nearest to the mirrored place, on the segment of the other side (of the trunk: its own).
  std::uint32_t on_template(std::uint32_t triangle) const;
  // The scan's, for a place that belongs to `segment`; nothing where the scan has no surface that faces that way within
  // 10 cm, as much as two sides of a person and the fits of both may differ.
  std::optional<std::uint32_t> on_scan(std::uint32_t triangle, std::size_t segment) const;

  // Between two triangles of one segment of the template at rest; between segments infinite.
  double distance(std::uint32_t template_triangle, std::uint32_t other) const;

 private:
  Eigen::Vector3d at_rest(std::uint32_t template_triangle) const;  // its middle, from its segment's joint

  const TemplateFit& fit_;
  JointTransforms at_scan_;
  SurfaceTarget scan_;
};

std::size_t mirrored_segment(std::size_t segment);

}  // namespace rotunda::recon
