#pragma once
// A triangle mesh with pictures on it, as scanners write it, and its colours brought to the vertices.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

enum class PictureWrap : std::uint8_t { repeat, mirrored, clamp };
struct SurfaceMaterial {
  int picture = -1;
  std::array<PictureWrap, 2> wrap = {PictureWrap::repeat, PictureWrap::repeat};  // along u and v
  Eigen::Vector3f factor = Eigen::Vector3f::Ones();                              // linear, times the picture
};

struct TexturedMesh {
  TriangleMesh mesh;
  std::vector<Eigen::Vector3f> shades;  // linear colours of the vertices; empty or one a vertex
  // Shades tint what the material says (glTF); otherwise they are what is seen where there is no picture.
  bool shades_tint = false;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;  // one a triangle; (0, 0) is the picture's top left corner
  std::vector<int> material;                       // one a triangle; -1: none, white
  std::vector<SurfaceMaterial> materials;
  std::vector<cv::Mat> pictures;  // CV_8UC3, sRGB, red first
};

// Sets the mesh's colours. A corner's is the mean of the picture within its triangle, over half of the way to the other
// corners (bilinear, in linear light); it leaves its chart nowhere. A place's is the mean of all corners that lie at
// exactly this place, so that nothing is seen of seams.
void paint_vertices(TexturedMesh& textured);

}  // namespace rotunda::recon
