#include "recon/hull/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "config/errors.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/rim_fit.h"
#include "recon/hull/rims.h"
#include "recon/hull/visual_hull.h"
#include "recon/mesh/simplify.h"
#include "recon/mesh/smoothing.h"

namespace rotunda::recon {
namespace {

constexpr double kSliverMargin = 0.15;   // cells: the shortest edges are 0.2 cells long
constexpr double kLiveCoarseness = 1.6;  // cells of 16 mm leave about 20 000 triangles of a person
constexpr int kLiveRimStride = 3;

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// Cameras with a silhouette, and those in whose picture nobody was found.
struct SortedViews {
  std::vector<SilhouetteView> with_silhouette;
  std::vector<capture::CameraModel> empty;
};

SortedViews sort_views(std::span<const SilhouetteView> views) {
  SortedViews sorted;
  for (const auto& view : views)
    if (view.is_empty())
      sorted.empty.push_back(view.camera());
    else
      sorted.with_silhouette.push_back(view);
  return sorted;
}

std::string names_of(std::span<const capture::CameraModel> cameras) {
  std::string names;
  for (const auto& camera : cameras) names += (names.empty() ? "" : ", ") + camera.name;
  return names;
}

bool in_picture(const capture::CameraModel& camera, const Eigen::Vector3f& point) {
  const auto pixel = capture::project(camera, point.cast<double>());
  return pixel && pixel->x() >= -0.5 && pixel->y() >= -0.5 && pixel->x() <= camera.width - 0.5 &&
         pixel->y() <= camera.height - 0.5;
}

// Of the cameras with an empty silhouette those that have the surface in their picture: their key failed, while the
// others are right that nobody is there.
std::vector<capture::CameraModel> watching(std::vector<capture::CameraModel> cameras, const TriangleMesh& mesh) {
  const auto misses_all = [&](const capture::CameraModel& camera) {
    return std::none_of(mesh.positions.begin(), mesh.positions.end(),
                        [&](const Eigen::Vector3f& point) { return in_picture(camera, point); });
  };
  cameras.erase(std::remove_if(cameras.begin(), cameras.end(), misses_all), cameras.end());
  return cameras;
}

SurfaceResult failed(SurfaceResult result, const std::string& why) {
  result.mesh = {};
  result.failure = why;
  return result;
}

// Fills bounds and cell size of the report; tells what is wrong with the frame, if anything.
std::string settle_volume(std::span<const SilhouetteView> views, const SurfaceOptions& options, SurfaceReport& report) {
  try {
    report.bounds = options.bounds ? *options.bounds : capture_volume(views);
  } catch (const InvalidInput& nothing) {
    return nothing.what();
  }
  report.cell_size = options.coarseness *
                     (options.cell_size > 0.0 ? options.cell_size : default_cell_size(report.bounds, options.unit));
  const Eigen::Vector3d sides = report.bounds.sizes();
  if (report.cell_size >= sides.minCoeff())
    return fmt::format(
        "cells of {:.4g} do not fit into the volume, {:.4g} x {:.4g} x {:.4g}: give them in the "
        "calibration's unit",
        report.cell_size, sides.x(), sides.y(), sides.z());
  return {};
}

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& position : mesh.positions) box.extend(position.cast<double>());
  return box;
}

// From the hull's surface to the body's.
void draw_in(std::span<const SilhouetteView> views, const SurfaceOptions& options, SurfaceResult& result) {
  const double metre = default_cell_size(result.report.bounds, options.unit) / kPersonCell;
  const auto rims = find_rims(views, rim_options(box_of(result.mesh), metre, options.rim_stride));
  result.report.rims = rims.size();
  compute_normals(result.mesh);
  fit_to_rims(result.mesh, rims, rim_fit_options(result.report.cell_size, metre));
}

void finish(TriangleMesh& mesh, const SurfaceOptions& options, double cell_size) {
  if (!options.fit_rims) smooth(mesh, {.rounds = options.smoothing_rounds});
  if (options.collapse_slivers) collapse_slivers(mesh, 0.2 * cell_size);
  if (options.triangles > 0) simplify(mesh, static_cast<std::size_t>(options.triangles));
  compute_normals(mesh);
}

}  // namespace

SurfaceOptions live_surface(SurfaceOptions options) {
  options.coarseness *= kLiveCoarseness;
  options.rim_stride = kLiveRimStride;
  options.collapse_slivers = false;
  options.triangles = 0;
  return options;
}

SurfaceResult reconstruct_surface(std::span<const SilhouetteView> all, const SurfaceOptions& options) {
  const double start = cpu_seconds();
  SurfaceResult result;
  if (all.size() < 2) throw InvalidInput("a surface needs at least two views");
  const auto [views, empty] = sort_views(all);
  if (views.size() < 2) return failed(std::move(result), "empty silhouette in " + names_of(empty));
  if (const auto problem = settle_volume(views, options, result.report); !problem.empty())
    return failed(std::move(result), problem);
  auto& report = result.report;
  auto grid = visual_hull(views, {report.bounds, report.cell_size, options.min_views, options.tolerate_misses});
  report.blocks = grid.block_count();
  report.cut = cut_to_genus_zero(grid);
  if (report.cut.solid_voxels == 0)
    return failed(std::move(result), "empty hull: no point of the volume lies inside all silhouettes");
  result.mesh = options.fit_rims ? marching_cubes(grid, kSliverMargin) : marching_cubes(grid);
  if (const auto failed_key = watching(empty, result.mesh); !failed_key.empty())
    return failed(std::move(result), "empty silhouette in " + names_of(failed_key));
  report.extracted_triangles = result.mesh.triangles.size();
  if (options.fit_rims) draw_in(views, options, result);
  finish(result.mesh, options, report.cell_size);
  report.triangles = result.mesh.triangles.size();
  report.cpu_s = cpu_seconds() - start;
  if (!topology_of(result.mesh).is_sphere()) return failed(std::move(result), "the surface is not a closed sphere");
  return result;
}

SurfaceResult reconstruct_surface(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                                  const SurfaceOptions& options) {
  return reconstruct_surface(silhouette_views(cameras, mattes), options);
}

}  // namespace rotunda::recon
