#pragma once
// Draws the frames of a geometry video, one after the other, from any viewpoint: in the colours stored with them, or in
// those of the take's own pictures (view_dependent_renderer.h). Needs a current GLES 3 context.
#include <filesystem>
#include <memory>
#include <optional>

#include "playback/render/view_program.h"
#include "playback/viewpoint.h"
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

class FramePainter {
 public:
  virtual ~FramePainter() = default;
  virtual void show(int frame) = 0;                   // of the video, counted from 0; drawn from now on
  virtual void draw(const Viewpoint& viewpoint) = 0;  // into the bound framebuffer
};

// `video` is lent.
std::unique_ptr<FramePainter> stored_painter(recon::GeometryVideoReader& video, const DrawOptions& options = {});

// `take`: the folder that the video was made from; `calibration`: instead of its own. A frame without a single picture
// is drawn in its stored colours. Throws what reading and keying a take throws (take_studio.h, take_plates.h).
std::unique_ptr<FramePainter> view_dependent_painter(recon::GeometryVideoReader& video,
                                                     const std::filesystem::path& take,
                                                     const std::optional<std::filesystem::path>& calibration);

}  // namespace rotunda::playback
