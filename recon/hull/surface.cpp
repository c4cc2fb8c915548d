#include "recon/hull/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <vector>

#include "config/errors.h"
#include "recon/hull/capture_volume.h"
#include "recon/hull/lost_parts.h"
#include "recon/hull/marching_cubes.h"
#include "recon/hull/photo_hull.h"
#include "recon/hull/photo_match.h"
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
constexpr double kLostPart = 0.020;  // metres: thinner parts that a matte lost are not looked for

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Runs `work` and notes what it cost.
template <class Work>
auto timed(SurfaceReport& report, const char* stage, Work&& work) {
  struct Note {
    SurfaceReport& report;
    const char* stage;
    std::chrono::steady_clock::time_point wall = std::chrono::steady_clock::now();
    double cpu = thread_cpu_ms();
    ~Note() {
      const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - wall;
      report.stages.push_back({stage, passed.count(), thread_cpu_ms() - cpu});
    }
  };
  const Note note{report, stage};
  return work();
}

// Cameras with a silhouette, and those in whose picture nobody was found.
struct SortedViews {
  std::vector<SilhouetteView> with_silhouette;
  std::vector<cv::Mat> pictures;  // theirs, or none
  std::vector<capture::CameraModel> empty;
};

SortedViews sort_views(std::span<const SilhouetteView> views, std::span<const cv::Mat> pictures) {
  SortedViews sorted;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].is_empty()) {
      sorted.empty.push_back(views[i].camera());
      continue;
    }
    sorted.with_silhouette.push_back(views[i]);
    if (!pictures.empty()) sorted.pictures.push_back(pictures[i]);
  }
  return sorted;
}

void check(std::span<const SilhouetteView> views, std::span<const cv::Mat> pictures, const SurfaceOptions& options) {
  if (views.size() < 2) throw InvalidInput("a surface needs at least two views");
  if (options.paper && pictures.empty()) throw InvalidInput("a photo hull needs the views' pictures");
  if (pictures.empty()) return;
  if (pictures.size() != views.size())
    throw InvalidInput(fmt::format("{} views but {} pictures: one a view is needed", views.size(), pictures.size()));
  for (std::size_t i = 0; i < views.size(); ++i)
    if (pictures[i].size() != views[i].distance_px().size() || pictures[i].type() != CV_8UC3)
      throw InvalidInput(fmt::format("{}: the picture has {} x {} pixels, the calibration says {} x {}",
                                     views[i].camera().name, pictures[i].cols, pictures[i].rows,
                                     views[i].camera().width, views[i].camera().height));
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

bool is_full(const SilhouetteView& view) {
  double least = 0.0;
  cv::minMaxLoc(view.distance_px(), &least);
  return least > 0.0;
}

// Why no point of the volume lies inside all silhouettes, as far as they tell.
std::string nothing_inside(std::span<const SilhouetteView> views, const SurfaceOptions& options) {
  const std::string what = "empty hull: no point of the volume lies inside all silhouettes";
  if (!options.bounds) return what + ": check that calibration and mattes (--mattes) belong together";
  try {
    const auto found = capture_volume(views);
    return fmt::format(
        "{}, which meet between ({:.3g}, {:.3g}, {:.3g}) and ({:.3g}, {:.3g}, {:.3g}): is it the volume of this rig?",
        what, found.min().x(), found.min().y(), found.min().z(), found.max().x(), found.max().y(), found.max().z());
  } catch (const InvalidInput&) {
    return what + ", nor any other point: check the calibration, and the mattes with --mattes";
  }
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

bool draws_in(const SurfaceOptions& options) {
  return options.fit_rims && !options.paper;
}

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& position : mesh.positions) box.extend(position.cast<double>());
  return box;
}

// One, or what is to this body as a metre is to a person.
double metre_of(const SurfaceReport& report, const SurfaceOptions& options) {
  return default_cell_size(report.bounds, options.unit) / kPersonCell;
}

PieceRule piece_rule(const SurfaceOptions& options, const SurfaceReport& report) {
  constexpr double kLitre = 1e-3;  // cubic metres
  const double metre = metre_of(report, options);
  return {options.performer_at, options.tied_litres * kLitre * metre * metre * metre};
}

std::vector<capture::CameraModel> cameras_of(std::span<const SilhouetteView> views) {
  std::vector<capture::CameraModel> cameras;
  for (const auto& view : views) cameras.push_back(view.camera());
  return cameras;
}

// From the hull's surface to the body's.
void draw_in(const SortedViews& views, const SurfaceOptions& options, SurfaceResult& result) {
  auto& report = result.report;
  const double metre = metre_of(report, options);
  compute_normals(result.mesh);
  const auto rims = timed(report, "rims", [&] {
    return find_rims(views.with_silhouette, rim_options(box_of(result.mesh), metre, options.rim_stride));
  });
  report.rims = rims.size();
  const auto hull = result.mesh;
  const auto fit = rim_fit_options(report.cell_size, metre, options.rim_stride);
  timed(report, "rim fit", [&] { fit_to_rims(result.mesh, rims, fit); });
  if (!options.match_pictures || views.pictures.empty()) return;
  const auto cameras = cameras_of(views.with_silhouette);
  timed(report, "matching", [&] { match_to_pictures(result.mesh, {cameras, views.pictures, rims, hull, fit, metre}); });
}

std::vector<ViewShare> shares_of(std::span<const SilhouetteView> views, std::span<const double> shares) {
  std::vector<ViewShare> some;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (shares[i] > 0.0) some.push_back({views[i].camera().name, shares[i]});
  return some;
}

void put_back_lost(SortedViews& views, const SurfaceOptions& options, SurfaceReport& report) {
  const double cube_size = std::max(report.cell_size, kLostPart * metre_of(report, options));
  auto back = put_back_lost_parts(views.with_silhouette, {report.bounds, cube_size});
  report.put_back = shares_of(views.with_silhouette, back.share);
  views.with_silhouette = std::move(back.views);
}

SignedGrid carved(const SortedViews& views, const SurfaceOptions& options, SurfaceReport& report) {
  auto grid = timed(report, "hull", [&] {
    return visual_hull(views.with_silhouette,
                       {report.bounds, report.cell_size, options.min_views, options.tolerate_misses});
  });
  report.blocks = grid.block_count();
  if (options.paper)
    timed(report, "photo hull", [&] {
      const PhotoHullOptions carving{.deepest = 0.05 * metre_of(report, options)};
      report.carved_voxels = carve_photo_hull(grid, views.with_silhouette, views.pictures, carving).carved;
    });
  timed(report, "genus cut", [&] { report.cut = cut_to_genus_zero(grid, piece_rule(options, report)); });
  if (options.tolerate_misses > 0)
    report.denied = shares_of(views.with_silhouette, denied_shares(views.with_silhouette, grid));
  return grid;
}

void finish(const SurfaceOptions& options, SurfaceResult& result) {
  auto& mesh = result.mesh;
  auto& report = result.report;
  if (!draws_in(options)) smooth(mesh, {.rounds = options.smoothing_rounds});
  timed(report, "simplify", [&] {
    if (options.collapse_slivers) collapse_slivers(mesh, 0.2 * report.cell_size);
    if (options.triangles > 0) simplify(mesh, static_cast<std::size_t>(options.triangles));
  });
  compute_normals(mesh);
  report.triangles = mesh.triangles.size();
  report.volume = signed_volume(mesh);
  report.area = surface_area(mesh);
  report.topology = topology_of(mesh);
}

}  // namespace

SurfaceOptions live_surface(SurfaceOptions options) {
  options.coarseness *= kLiveCoarseness;
  options.rim_stride = kLiveRimStride;
  options.match_pictures = false;
  options.put_back_lost = false;
  options.triangles = 0;
  return options;
}

SurfaceResult reconstruct_surface(std::span<const SilhouetteView> all, std::span<const cv::Mat> pictures,
                                  const SurfaceOptions& options) {
  const double start = cpu_seconds();
  check(all, pictures, options);
  SurfaceResult result;
  auto& report = result.report;
  auto views = sort_views(all, pictures);
  if (views.with_silhouette.size() < 2)
    return failed(std::move(result), "empty silhouette in " + names_of(views.empty));
  if (std::all_of(views.with_silhouette.begin(), views.with_silhouette.end(), is_full))
    return failed(std::move(result), "the silhouettes fill all pictures: the key found no backdrop");
  if (const auto problem = settle_volume(views.with_silhouette, options, report); !problem.empty())
    return failed(std::move(result), problem);
  if (options.put_back_lost && options.tolerate_misses == 0)
    timed(report, "lost parts", [&] { put_back_lost(views, options, report); });
  const auto grid = carved(views, options, report);
  if (report.cut.solid_voxels == 0) return failed(std::move(result), nothing_inside(views.with_silhouette, options));
  result.mesh = timed(report, "marching cubes",
                      [&] { return draws_in(options) ? marching_cubes(grid, kSliverMargin) : marching_cubes(grid); });
  if (const auto failed_key = watching(views.empty, result.mesh); !failed_key.empty())
    return failed(std::move(result), "empty silhouette in " + names_of(failed_key));
  report.extracted_triangles = result.mesh.triangles.size();
  if (draws_in(options)) draw_in(views, options, result);
  finish(options, result);
  report.cpu_s = cpu_seconds() - start;
  if (!report.topology.is_sphere()) return failed(std::move(result), "the surface is not a closed sphere");
  return result;
}

SurfaceResult reconstruct_surface(std::span<const SilhouetteView> views, const SurfaceOptions& options) {
  return reconstruct_surface(views, {}, options);
}

SurfaceResult reconstruct_surface(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                                  const SurfaceOptions& options) {
  return reconstruct_surface(silhouette_views(cameras, mattes), options);
}

}  // namespace rotunda::recon
