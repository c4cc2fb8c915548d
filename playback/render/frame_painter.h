#pragma once
// Draws the frames of something that moves, one after the other, from any viewpoint: a geometry video in the colours
// stored with it, or any surface in those of a take's own pictures (view_dependent_renderer.h). Needs a current GLES 3
// context.
#include <functional>
#include <memory>

#include "playback/render/take_pictures.h"
#include "playback/render/view_program.h"
#include "playback/viewpoint.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

class FramePainter {
 public:
  virtual ~FramePainter() = default;
  virtual void show(int frame) = 0;                   // counted from 0; drawn from now on
  virtual void draw(const Viewpoint& viewpoint) = 0;  // into the bound framebuffer
};

// `video` is lent.
std::unique_ptr<FramePainter> stored_painter(recon::GeometryVideoReader& video, const DrawOptions& options = {});

// The surface that stands where the performer did in a frame, counted from 0. World, metres.
using SurfaceOf = std::function<recon::TriangleMesh(int frame)>;

// Frame 0 is `first_frame` of the take. A frame without a single picture is drawn in the surface's own colours, and so
// is what no camera sees; a surface without colours is grey there.
std::unique_ptr<FramePainter> view_dependent_painter(SurfaceOf surface_of, std::shared_ptr<TakePictures> pictures,
                                                     std::size_t first_frame);
// A geometry video, lent, in the pictures of the take that it was made of.
std::unique_ptr<FramePainter> view_dependent_painter(recon::GeometryVideoReader& video,
                                                     std::shared_ptr<TakePictures> pictures);

}  // namespace rotunda::playback
