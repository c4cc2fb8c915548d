#include "recon/hull/surface.h"

#include <fmt/format.h>

#include <ctime>

#include "config/errors.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/signed_silhouette.h"
#include "recon/hull/visual_hull.h"
#include "recon/mesh/simplify.h"
#include "recon/mesh/smoothing.h"

namespace rotunda::recon {
namespace {

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::string empty_silhouettes(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes) {
  std::string names;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (is_empty(mattes[i])) names += (names.empty() ? "" : ", ") + cameras[i].name;
  return names;
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
  report.cell_size = options.cell_size > 0.0 ? options.cell_size : default_cell_size(report.bounds, options.unit);
  return {};
}

void finish(TriangleMesh& mesh, const SurfaceOptions& options, double cell_size) {
  smooth(mesh, {.rounds = options.smoothing_rounds});
  collapse_slivers(mesh, 0.2 * cell_size);
  if (options.triangles > 0) simplify(mesh, static_cast<std::size_t>(options.triangles));
  compute_normals(mesh);
}

}  // namespace

SurfaceResult reconstruct_surface(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                                  const SurfaceOptions& options) {
  const double start = cpu_seconds();
  SurfaceResult result;
  const auto views = silhouette_views(cameras, mattes);
  if (const auto empty = empty_silhouettes(cameras, mattes); !empty.empty())
    return failed(std::move(result), "empty silhouette in " + empty);
  if (const auto problem = settle_volume(views, options, result.report); !problem.empty())
    return failed(std::move(result), problem);
  auto& report = result.report;
  auto grid = visual_hull(views, {report.bounds, report.cell_size, options.min_views, options.tolerate_misses});
  report.blocks = grid.block_count();
  report.cut = cut_to_genus_zero(grid);
  if (report.cut.solid_voxels == 0)
    return failed(std::move(result), "empty hull: no point of the volume lies inside all silhouettes");
  result.mesh = marching_cubes(grid);
  report.extracted_triangles = result.mesh.triangles.size();
  finish(result.mesh, options, report.cell_size);
  report.triangles = result.mesh.triangles.size();
  report.cpu_s = cpu_seconds() - start;
  if (!topology_of(result.mesh).is_sphere()) return failed(std::move(result), "the surface is not a closed sphere");
  return result;
}

}  // namespace rotunda::recon
