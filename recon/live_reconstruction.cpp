#include "recon/live_reconstruction.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "config/errors.h"
#include "recon/colour/live_colour.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/surface.h"

namespace rotunda::recon {
namespace {

// Of the offline cell: the hull's cost goes with the square, and a viewer shows half of that detail at most.
constexpr double kCoarser = 2.0;
// Cells a pixel of a silhouette may cover: its outline is known to a tenth of a pixel.
constexpr double kCoarsestPixel = 0.5;

struct SearchedVolume {
  Eigen::AlignedBox3d bounds;
  double cell_size = 0.0;
};

// How many pixels, along each axis, become one of the silhouette.
int reduction_of(const capture::CameraModel& camera, const SearchedVolume& volume) {
  const double depth = camera.R.row(2).dot(volume.bounds.center()) + camera.t.z();
  const double pixel = depth / std::max(camera.K(0, 0), camera.K(1, 1));
  int reduction = 1;
  while (2 * reduction * pixel < kCoarsestPixel * volume.cell_size && camera.width >= 64 * reduction) reduction *= 2;
  return reduction;
}

// The mean of each `reduction` x `reduction` pixels; odd ones at the right and below are left out.
SilhouetteView reduced_view(capture::CameraModel camera, const capture::Matte& matte, int reduction) {
  if (reduction == 1) return {camera, matte};
  camera.width /= reduction;
  camera.height /= reduction;
  camera.K.topRows<2>() /= reduction;
  for (int row = 0; row < 2; ++row) camera.K(row, 2) += 0.5 / reduction - 0.5;
  const cv::Rect whole(0, 0, camera.width * reduction, camera.height * reduction);
  capture::Matte small;
  cv::resize(matte.alpha(whole), small.alpha, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  return {camera, small};
}

std::vector<SilhouetteView> reduced_views(const FrameViews& views, const SearchedVolume& volume) {
  std::vector<std::optional<SilhouetteView>> made(views.cameras.size());
  tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t i) {
    made[i].emplace(reduced_view(views.cameras[i], views.mattes[i], reduction_of(views.cameras[i], volume)));
  });
  std::vector<SilhouetteView> result;
  for (auto& view : made) result.push_back(std::move(*view));
  return result;
}

// Tells in `failure` if nobody is found anywhere.
SearchedVolume volume_of(const FrameViews& views, const StudioViews& studio, const LiveOptions& options,
                         std::string& failure) {
  SearchedVolume volume;
  try {
    volume.bounds = options.bounds ? *options.bounds : capture_volume(silhouette_views(views.cameras, views.mattes));
  } catch (const InvalidInput& nothing) {
    failure = nothing.what();
    return volume;
  }
  volume.cell_size =
      options.cell_size > 0.0 ? options.cell_size : kCoarser * default_cell_size(volume.bounds, studio.unit);
  return volume;
}

// Cells are coarse already, and a reduced outline has fewer points.
SurfaceOptions surface_options(const FrameViews& views, const SearchedVolume& volume, const std::string& unit) {
  auto surface = live_surface({.bounds = volume.bounds, .cell_size = volume.cell_size, .unit = unit});
  surface.coarseness = 1.0;
  int reduction = 1;
  for (const auto& camera : views.cameras) reduction = std::max(reduction, reduction_of(camera, volume));
  surface.rim_stride = std::max(1, surface.rim_stride / reduction);
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
  const auto volume = volume_of(frame.views, studio, options, frame.failure);
  if (!frame.failure.empty()) return frame;
  const auto views = clock.run("silhouette", [&] { return reduced_views(frame.views, volume); });
  auto surface = clock.run(
      "surface", [&] { return reconstruct_surface(views, surface_options(frame.views, volume, studio.unit)); });
  frame.failure = surface.failure;
  if (!frame.failure.empty()) return frame;
  frame.mesh = std::move(surface.mesh);
  clock.run("colour", [&] { colour_live(frame.mesh, quick_views(frame.views), studio.backdrop); });
  return frame;
}

}  // namespace rotunda::recon
