#pragma once
// A take's frame on its floor: in its stored colours, or in those of its cameras' own pictures. World, metres. Needs a
// current GLES 3 context.
#include <optional>
#include <span>

#include "playback/render/geometry_image_renderer.h"
#include "playback/render/stage.h"
#include "playback/render/view_dependent_renderer.h"

namespace rotunda::playback {

class TakeView {
 public:
  // What is drawn from now on; with views, in their colours (view_dependent_renderer.h).
  void show(const recon::GeometryImage& image, std::span<const SourceView> views = {});
  // What lies `share` (0 to 1) of the way between two frames of an aligned take, in stored colours.
  void show_between(const GeometryImageRenderer::Numbered& from, const GeometryImageRenderer::Numbered& to,
                    double share);
  // Into the bound framebuffer. `performer`: over which point of the floor they are. `coarser`: levels of detail below
  // the frame's own, of stored colours.
  void draw(const Viewpoint& viewpoint, const Eigen::Vector3d& performer, const DrawOptions& options, int coarser = 0);

 private:
  GeometryImageRenderer stored_;
  std::optional<ViewDependentRenderer> from_pictures_;  // made when first needed: not every driver can
  Stage stage_;
  std::optional<bool> has_floor_;  // told by the first frame
  int level_ = 0;                  // of the frame
  bool in_pictures_ = false;
};

}  // namespace rotunda::playback
