#pragma once
// What every renderer's shaders share: the projection of a Viewpoint (exact at the vertices: distortion is applied per
// vertex, so triangles must be small beside the lens's curvature, as ours of about a centimetre are), the colours or
// the grey of the surface, and which faces show.
#include <array>
#include <optional>

#include "playback/render/gl_objects.h"
#include "playback/viewpoint.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

enum class Shading {
  colour,  // as the cameras saw it: the light is in the colours
  grey,    // plain grey under a lamp at the eye: shows the shape
  lit      // colours that are no pictures (of what was measured) under that lamp
};

struct DrawOptions {
  Shading shading = Shading::colour;
  bool cull = true;  // back faces are not drawn: halves the work of a closed surface, the picture is the same
};

// Empties the bound framebuffer: to the background, or without one to nothing (alpha 0).
void clear(const std::optional<recon::Colour>& background);

// Where a viewpoint shows the world, without its distortion: clip = matrix * (x, y, z, 1).
Eigen::Matrix4f clip_from_world(const Viewpoint& viewpoint, const DepthRange& range);

// Programs made of one vertex shader body, compiled when first used: colour, grey or lit, with or without distortion.
// The body defines `vec3 place()` (world), `vec3 outwards()` (world, either sign) and `paint()`, which sets what the
// fragment body's `vec3 colour()` reads.
class ViewProgram {
 public:
  ViewProgram(std::string_view vertex_body, std::string_view fragment_body);
  // Binds the right program, sets the viewpoint, culling and depth test; returns it for the caller's own uniforms.
  const GlProgram& use(const Viewpoint& viewpoint, const DepthRange& range, const DrawOptions& options);

 private:
  std::string vertex_body_, fragment_body_;
  std::array<std::optional<GlProgram>, 6> programs_;
};

}  // namespace rotunda::playback
