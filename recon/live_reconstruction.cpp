#include "recon/live_reconstruction.h"

#include <algorithm>

#include "recon/colour/live_colour.h"
#include "recon/hull/capture_volume.h"

namespace rotunda::recon {
namespace {

// Of the offline cell: the hull's cost goes with the square, and a viewer shows half of that detail at most.
constexpr double kCoarser = 2.0;

SurfaceOptions surface_options(const StudioViews& studio, const LiveOptions& options) {
  auto surface = live_surface({.bounds = options.bounds, .cell_size = options.cell_size, .unit = studio.unit});
  surface.coarseness = options.cell_size > 0.0 ? 1.0 : kCoarser;
  return surface;
}

// As they come: taking spill out of a picture costs more than a whole live surface may.
std::vector<ColourView> quick_views(const FrameViews& views) {
  std::vector<ColourView> result;
  for (std::size_t i = 0; i < views.cameras.size(); ++i)
    result.push_back({.camera = views.cameras[i],
                      .rgb = views.pictures[i],
                      .matte = views.mattes[i],
                      .colour = views.colour.empty() ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : views.colour[i]});
  return result;
}

}  // namespace

LiveFrame reconstruct_live(const capture::FrameSet& frame_set, const StudioViews& studio, const LiveOptions& options,
                           StageClock& clock) {
  LiveFrame frame{.mesh = {}, .views = key_frame(frame_set, studio, {}, clock), .failure = {}};
  if (frame.views.cameras.size() < 2) {
    frame.failure = "fewer than two cameras have a picture";
    return frame;
  }
  auto surface = clock.run("surface", [&] {
    return reconstruct_surface(frame.views.cameras, frame.views.mattes, surface_options(studio, options));
  });
  frame.failure = surface.failure;
  if (!surface.failure.empty()) return frame;
  frame.mesh = std::move(surface.mesh);
  clock.run("colour", [&] { colour_live(frame.mesh, quick_views(frame.views), studio.backdrop); });
  return frame;
}

}  // namespace rotunda::recon
