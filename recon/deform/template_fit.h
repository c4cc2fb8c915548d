#pragma once
// The body template brought onto a scan: lengths, widths and pose of whoever stands there, so that nobody has to mark
// where elbows and knees are. Correspondences are nearest points with normals that agree, both ways; Levenberg-
// Marquardt over all measures and joints together with what is known of people (proportions at a height, ranges of
// motion) as a prior. The scan stands upright in metres, facing +x, its arms away from the body (A- or T-pose).
#include "recon/body/body_template.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct TemplateFit {
  BodyTemplate body;
  Pose pose;               // the body as the scan stands
  double distance = 0.0;   // of the scan's surface from the template's, median, metres
  double far_share = 0.0;  // of the scan's surface farther away than 5 cm or facing elsewhere
};

// Throws InvalidInput for a scan without triangles or normals. Whether the fit can be trusted, distance and far_share
// tell.
TemplateFit fit_template(const TriangleMesh& scan);

}  // namespace rotunda::recon
