#pragma once
// Draws a TriangleMesh with its colours, or grey without them. World frame, metres. Needs a current GLES 3 context;
// throws DeviceError if the driver refuses the shaders.
#include <optional>

#include "playback/render/gl_objects.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

class MeshRenderer {
 public:
  MeshRenderer();
  // Throws InvalidInput if a triangle points beyond the vertices, or normals or colours are fewer than they.
  void upload(const recon::TriangleMesh& mesh);
  void draw(const Viewpoint& viewpoint, const DrawOptions& options = {});  // into the bound framebuffer
  const Eigen::AlignedBox3d& box() const { return box_; }                  // of what was uploaded

 private:
  ViewProgram program_;
  GlVertexArray vertices_;
  GlBuffer positions_, normals_, colours_, triangles_;
  GLsizei indices_ = 0;
  bool coloured_ = false;
  Eigen::AlignedBox3d box_;
};

// One picture in one call: CV_8UC4, straight alpha, of the viewpoint's size; alpha 0 where nothing is drawn unless a
// background is given. Needs a current context.
cv::Mat render_mesh(const recon::TriangleMesh& mesh, const Viewpoint& viewpoint, const DrawOptions& options = {},
                    const std::optional<recon::Colour>& background = std::nullopt);

}  // namespace rotunda::playback
