#pragma once
// A frame seen from any viewpoint in the colours of its cameras' own pictures (ALGORITHMS step 11; Buehler et al. 2001,
// unstructured lumigraph rendering): the surface is the proxy on which each pixel of the new picture is looked up in
// every camera's, and the finds are mixed. A camera counts by
//   how near its direction is to the viewpoint's, seen from the surface (so that gloss and a wrong surface do least
//   harm), the cosine of facing, its sampling density where that is below the viewpoint's, how well inside of its matte
//   and how clear of other parts' edges in its depth map the find lies.
// Where no camera sees the surface it keeps its own colours, and they come in smoothly. World frame, metres. Any number
// of cameras of any sizes. Deterministic: cameras are added up in their order. Needs a current GLES 3 context with
// floating-point framebuffers that blend (EXT_color_buffer_float, EXT_float_blend: Mesa's software renderer has them);
// throws DeviceError without.
#include <optional>
#include <span>
#include <vector>

#include "playback/render/gl_objects.h"
#include "playback/render/source_view.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

struct ViewDependentOptions {
  double depth_tolerance_px = 3.0;  // how far behind a camera's depth map the surface may lie, in its pixels there
  double angle_power = 2.0;         // a camera counts by the angle to the viewpoint to minus this power
};

class ViewDependentRenderer {
 public:
  explicit ViewDependentRenderer(const ViewDependentOptions& options = {});
  // One moment: its surface with colours, and the pictures of it. Draws the cameras' depth maps.
  // Throws InvalidInput for a mesh without colours or with triangles beyond its vertices, a picture that is not of its
  // camera's size, or no view at all.
  void upload(const recon::TriangleMesh& surface, std::span<const SourceView> views);
  // Into the bound framebuffer; its depth buffer stays as it is.
  void draw(const Viewpoint& viewpoint);

 private:
  struct Layer {  // a picture to draw into, of one format
    GlTexture colour, depth;
    GlFramebuffer framebuffer;
    int width = 0, height = 0;
  };
  struct Source {
    capture::CameraModel camera;
    GlTexture picture;
    Layer depth;
    double focal = 1.0;  // pixels
  };
  static Layer make_layer(GLenum format, int width, int height);
  static void bind(const Layer& layer);
  void upload_surface(const recon::TriangleMesh& surface);
  Source make_source(const SourceView& view);
  void draw_surface(ViewProgram& program, const Viewpoint& viewpoint, const Layer& into, float empty);
  void add(const Source& source, const Viewpoint& viewpoint);
  void resize(int width, int height);

  ViewDependentOptions options_;
  ViewProgram places_, normals_, colours_, depths_;
  GlProgram add_, mix_;
  GlVertexArray surface_, nothing_;
  GlBuffer positions_, outwards_, own_, triangles_;
  GLsizei indices_ = 0;
  Eigen::AlignedBox3d box_;
  std::vector<Source> sources_;
  Layer place_, normal_, colour_, sum_;  // of the viewpoint's size
};

// One picture in one call: CV_8UC4, straight alpha, of the viewpoint's size, alpha 0 where nothing is unless a
// background is given. Needs a current context.
cv::Mat render_view_dependent(const recon::TriangleMesh& surface, std::span<const SourceView> views,
                              const Viewpoint& viewpoint,
                              const std::optional<recon::Colour>& background = std::nullopt);

}  // namespace rotunda::playback
