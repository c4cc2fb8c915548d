#include "recon/frame_reconstruction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "capture/matte/chroma_key.h"
#include "capture/matte/despill.h"
#include "capture/picture.h"
#include "recon/colour/surface_colour.h"
#include "recon/hull/matte_support.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/relaxed_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/video/lattice_normals.h"

namespace rotunda::recon {
namespace {

capture::Matte matte_for(const capture::Image& image, const cv::Mat& picture, const StudioViews& studio,
                         std::size_t camera, const cv::Mat& held) {
  if (camera < studio.live_keys.size() && studio.live_keys[camera]) return (*studio.live_keys[camera])(image);
  const cv::Mat stage = camera < studio.stages.size() ? studio.stages[camera] : cv::Mat();
  return capture::chroma_key(picture, {.backdrop = studio.backdrop, .stage = stage, .held = held},
                             studio.backgrounds[camera]);
}

bool shows_somebody(const capture::Matte& matte) {
  return cv::countNonZero(matte.alpha >= 128) > 0;
}

// Where the volume leaves fewer than two cameras anybody, all are keyed as if there were none: the surface will then
// tell where the performer is instead. (In the volume there is nobody still: the pixels that see it are empty.)
void look_beyond_volume(FrameViews& views, const std::vector<bool>& given, const StudioViews& studio) {
  const auto seeing = std::count_if(views.mattes.begin(), views.mattes.end(), shows_somebody);
  if (studio.stages.empty() || seeing >= 2) return;
  views.silhouettes.clear();
  for (std::size_t i = 0; i < views.mattes.size(); ++i) {
    const auto camera = std::find_if(studio.cameras.begin(), studio.cameras.end(),
                                     [&](const auto& model) { return model.name == views.cameras[i].name; });
    const auto& plate = studio.backgrounds[static_cast<std::size_t>(camera - studio.cameras.begin())];
    if (!given[i])
      views.mattes[i] = capture::chroma_key(views.pictures[i], {.backdrop = studio.backdrop, .stage = {}}, plate);
  }
}

// Mattes that somebody gave stay as they are, but have their say on the others.
void keep_supported(FrameViews& views, const std::vector<bool>& given, const StudioViews& studio) {
  if (!studio.volume || views.cameras.size() < 2) return;
  auto supported =
      supported_mattes(views.cameras, views.mattes, {.bounds = studio.volume, .unit = studio.unit, .keep = given});
  views.mattes = std::move(supported.mattes);
  views.silhouettes = std::move(supported.views);
  for (const auto i : supported.disagreeing) views.disagreeing.push_back(views.cameras[i].name);
}

// Colours spread along edges from seen vertices to unseen ones, ring by ring.
void fill_unseen_vertices(TriangleMesh& mesh, std::vector<std::uint8_t> seen) {
  for (bool any = true; any;) {
    any = false;
    std::vector<std::array<unsigned, 4>> sums(mesh.positions.size());  // red, green, blue, count
    for (const auto& triangle : mesh.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto from = triangle[i], to = triangle[(i + 1) % 3];
        if (!seen[from] || seen[to]) continue;
        for (std::size_t c = 0; c < 3; ++c) sums[to][c] += mesh.colours[from][c];
        ++sums[to][3];
      }
    for (std::size_t v = 0; v < sums.size(); ++v) {
      if (sums[v][3] == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) mesh.colours[v][c] = static_cast<std::uint8_t>(sums[v][c] / sums[v][3]);
      seen[v] = 255;
      any = true;
    }
  }
}

std::uint8_t mix(std::uint8_t a, std::uint8_t b, double share) {
  return static_cast<std::uint8_t>(std::lround(a + (b - a) * share));
}

}  // namespace

std::vector<ColourView> colour_views(const FrameViews& views) {
  std::vector<ColourView> result;
  for (std::size_t i = 0; i < views.cameras.size(); ++i)
    result.push_back({.camera = views.cameras[i],
                      .rgb = views.pictures[i],
                      .matte = views.mattes[i],
                      .colour = views.colour.empty() ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : views.colour[i],
                      .clean = i < views.images.size() && capture::is_mosaic(views.images[i].format)
                                   ? capture::despilled(views.images[i], views.mattes[i], views.backdrop)
                                   : cv::Mat()});
  return result;
}

FrameViews key_frame(const capture::FrameSet& frame_set, const StudioViews& studio,
                     std::span<const capture::Matte> given_mattes, StageClock& clock, std::span<const cv::Mat> held) {
  FrameViews views;
  views.backdrop = studio.backdrop;
  std::vector<bool> is_given;
  for (std::size_t i = 0; i < frame_set.slots.size(); ++i) {
    auto picture = clock.run("demosaic", [&] { return capture::picture_of(frame_set.slots[i]); });
    if (picture.rgb.empty()) continue;
    views.cameras.push_back(studio.cameras[i]);
    if (!studio.colour.empty()) views.colour.push_back(studio.colour[i]);
    views.pictures.push_back(std::move(picture.rgb));
    views.images.push_back(frame_set.slots[i].frame->image);
    const bool given = i < given_mattes.size() && !given_mattes[i].alpha.empty();
    is_given.push_back(given);
    views.mattes.push_back(given ? given_mattes[i] : clock.run("key", [&] {
      return matte_for(frame_set.slots[i].frame->image, views.pictures.back(), studio, i,
                       i < held.size() ? held[i] : cv::Mat());
    }));
  }
  clock.run("support", [&] {
    keep_supported(views, is_given, studio);
    look_beyond_volume(views, is_given, studio);
  });
  return views;
}

MappedFrame map_frame(const FrameViews& views, const SurfaceOptions& options, StageClock& clock) {
  if (views.cameras.size() < 2) return {std::nullopt, "fewer than two cameras have a picture of this frame", {}};
  auto surface = clock.run("surface", [&] {
    return views.silhouettes.empty()
               ? reconstruct_surface(silhouette_views(views.cameras, views.mattes), views.pictures, options)
               : reconstruct_surface(views.silhouettes, views.pictures, options);
  });
  surface.report.disagreeing = views.disagreeing;
  if (!surface.failure.empty()) return {std::nullopt, surface.failure, std::move(surface.report)};
  auto sphere = clock.run("sphere", [&] { return map_to_sphere(surface.mesh); });
  if (!sphere.map) return {std::nullopt, sphere.report.failure, std::move(surface.report)};
  return {MappedSurface{std::move(surface.mesh), std::move(*sphere.map)}, "", std::move(surface.report)};
}

void colour_vertices(TriangleMesh& mesh, const FrameViews& views, StageClock& clock) {
  clock.run("vertices", [&] {
    auto colour = surface_colour(mesh.positions, mesh.normals, mesh, colour_views(views), {.backdrop = views.backdrop});
    mesh.colours = std::move(colour.colours);
    fill_unseen_vertices(mesh, std::move(colour.coverage));
  });
}

GeometryImage sample_frame(const MappedSurface& surface, const FrameViews& views, int level, int colour_level,
                           StageClock& clock) {
  auto lattice = clock.run("lattice", [&] { return relaxed_lattice(surface.mesh, surface.map, level); });
  auto image = clock.run("resample", [&] { return resample(surface.mesh, surface.map, lattice); });
  image.colour_level = colour_level;
  clock.run("colour", [&] {
    for (int finer = level + 1; finer <= colour_level; ++finer) lattice = refine_directions(lattice, finer);
    const auto points = surface_points(surface.mesh, surface.map, lattice);
    auto colour = surface_colour(points.positions, points.normals, surface.mesh, colour_views(views),
                                 {.backdrop = views.backdrop});
    image.colours = std::move(colour.colours);
    image.coverage = std::move(colour.coverage);
    fill_unseen(image);
  });
  return image;
}

GeometryImage interpolate(const GeometryImage& a, const GeometryImage& b, double share) {
  GeometryImage between = a;
  for (std::size_t i = 0; i < a.positions.size(); ++i)
    between.positions[i] += static_cast<float>(share) * (b.positions[i] - a.positions[i]);
  for (std::size_t i = 0; i < a.colours.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) between.colours[i][c] = mix(a.colours[i][c], b.colours[i][c], share);
  between.normals = lattice_normals(between.positions, between.level);
  return between;
}

}  // namespace rotunda::recon
