#pragma once
// The floor a character stands on: a lit disc that fades out, with the soft shadow of the body. Shadow: the body seen
// from above on a small picture, blurred by the lamp's size. World: z up, floor at z = 0. Needs a current GLES 3
// context.
#include <functional>
#include <optional>

#include "playback/render/gl_objects.h"
#include "playback/viewpoint.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::playback {

inline constexpr recon::Colour kDarkRoom{24, 26, 30};  // behind what windows show

struct StageOptions {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  // the disc's middle, metres
  double radius = 3.0;
  double floor_height = 0.0;
  recon::Colour colour{92, 94, 100};
  std::optional<recon::Colour> background;  // behind the disc; not given: it fades to alpha 0
};

class Stage {
 public:
  Stage();
  // Draws the floor into the bound framebuffer, whose depth it leaves alone: draw the body after it. `draw_body` draws
  // the body through a viewpoint.
  void draw(const Viewpoint& viewpoint, const StageOptions& options,
            const std::function<void(const Viewpoint&)>& draw_body);

 private:
  void make_shadow(const StageOptions& options, const std::function<void(const Viewpoint&)>& draw_body);

  RenderTarget outline_;
  GlTexture shadow_;
  GlProgram program_;
  GlVertexArray vertices_;
};

}  // namespace rotunda::playback
