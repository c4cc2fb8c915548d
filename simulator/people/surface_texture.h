#pragma once
// A texture for any triangle mesh without a parametrisation: pairs of triangles each get a small square of texels
// (a "mesh colour" atlas; Yuksel et al. 2010 motivate it). Every triangle has its own corners; there are no mip levels.
#include <functional>
#include <opencv2/core.hpp>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::simulator {

struct SurfaceTexture {
  cv::Mat picture;                       // CV_8UC3, sRGB
  std::vector<Eigen::Vector2f> corners;  // three a triangle, in texels; (0.5, 0.5) is the centre of the first one
};

// sRGB, 0 to 1, of a point on (or a texel beside) a triangle. Asked from several threads.
using PaintAt = std::function<Eigen::Vector3d(std::size_t triangle, const Eigen::Vector3d& point)>;

// `texels` along a triangle's edge, 2 or more.
SurfaceTexture paint_surface(const recon::TriangleMesh& mesh, int texels, const PaintAt& colour);

}  // namespace rotunda::simulator
