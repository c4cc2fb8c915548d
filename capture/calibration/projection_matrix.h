#pragma once
// Projection matrices P = s K [R | t], 3x4, up to a factor s of any size and sign (Hartley, Zisserman 2003, 6.2).
// Pixel (0, 0) is the centre of the top-left pixel, as everywhere here; K may have skew.
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"

namespace rotunda::capture {

using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;

// K [R | t]; the distortion is not in it.
ProjectionMatrix projection_matrix(const CameraModel& camera);

enum class Handedness { right, left };

struct DecomposedProjections {
  std::vector<CameraModel> cameras;  // K, R, t alone; focal lengths positive
  Handedness handedness = Handedness::right;
};

// The matrices' signs are chosen by what the cameras look at: the point nearest to all optical axes must lie before
// each of them. If then every det R is -1, the set is left-handed and kept so (calibration_file.h). Where the axes have
// no such point (they are parallel, or it is one camera) the set is taken to be right-handed.
// Throws InvalidInput naming (by `names`) a matrix whose camera is at infinity or that is not finite, and a set that is
// neither right- nor left-handed as a whole.
DecomposedProjections decompose(std::span<const ProjectionMatrix> projections, std::span<const std::string> names);

}  // namespace rotunda::capture
