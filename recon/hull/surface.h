#pragma once
// Silhouettes of one FrameSet to one closed genus-0 surface: signed hull, cut to genus 0, Marching Cubes, drawn in
// between the rims to where the body is (rim_fit.h), simplified, with normals. World frame and units (metres).
// ALGORITHMS step 3. Pure: no files, no log; the same result on any number of threads.
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/matte.h"
#include "recon/hull/genus_cut.h"
#include "recon/hull/silhouette_view.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct SurfaceOptions {
  std::optional<Eigen::AlignedBox3d> bounds;  // the rig's volume; searched for if not given
  double cell_size = 0.010;                   // world units; 0: by the volume's size (default_cell_size)
  double coarseness = 1.0;                    // of cells, times their size
  std::string unit = "m";                     // of the calibration
  int triangles = 20000;                      // at most; 0: all
  int min_views = 2;
  int tolerate_misses = 0;
  std::optional<Eigen::Vector2d> performer_at;  // world, x and y: of several people this one; else the largest piece
  double tied_litres =
      0.0;  // pieces that touch nobody and are at least so large stay, on a thread; 0: they are dropped
  bool put_back_lost =
      true;              // what one or two mattes lost against all others (lost_parts.h), unless misses are tolerated
  bool fit_rims = true;  // else the surface is the hull's
  int rim_stride = 1;    // every so manieth outline point makes a rim
  bool match_pictures = true;  // where there are pictures: the fitted surface goes to where they agree (photo_fit.h)
  bool paper = false;          // as the first paper has it: the photo hull (photo_hull.h), smoothed, not fitted to rims
  bool collapse_slivers = true;
  int smoothing_rounds = 10;  // of the hull's surface; 0: none
};

// The same at live quality, for a few milliseconds: coarser cells, fewer rims, triangles as they come.
SurfaceOptions live_surface(SurfaceOptions options);

struct SurfaceStage {
  std::string name;
  double wall_ms = 0.0, cpu_ms = 0.0;  // CPU of the calling thread
};

struct ViewShare {
  std::string camera;
  double share = 0.0;
};

struct SurfaceReport {
  Eigen::AlignedBox3d bounds;  // searched
  double cell_size = 0.0;      // used
  std::size_t blocks = 0;      // of the sparse grid
  GenusCutReport cut;
  std::size_t rims = 0;  // that the surface was fitted to
  std::size_t extracted_triangles = 0;
  std::size_t triangles = 0;
  std::size_t carved_voxels = 0;  // of the photo hull
  MeshTopology topology;
  std::vector<std::string> disagreeing;  // cameras whose mattes the others do not support (matte_support.h), if known
  std::vector<ViewShare> put_back;       // of a view's silhouette: what it had lost, by the others
  std::vector<ViewShare> denied;         // of the solid: what a view would have cut off if misses were not tolerated
  double volume = 0.0, area = 0.0;       // of the mesh, world units cubed and squared
  std::vector<SurfaceStage> stages;      // in their order
  double cpu_s = 0.0;                    // of the calling thread's process while it ran
};

struct SurfaceResult {
  TriangleMesh mesh;  // empty on failure
  SurfaceReport report;
  std::string failure;  // empty if fine; e.g. "empty silhouette in cam03"
};

// A camera with an empty silhouette takes no part if the surface of the others lies wholly outside of its picture; if
// it has any of it in view, its key failed. What can happen to a frame (that, an empty hull) is the result's `failure`.
// `pictures`: RGB, one a view, or none at all: then silhouettes alone tell.
// Throws InvalidInput for the caller's mistakes: spans of unequal size, fewer than two views, a matte or picture of
// another size than its camera, paper without pictures.
SurfaceResult reconstruct_surface(std::span<const SilhouetteView> views, std::span<const cv::Mat> pictures,
                                  const SurfaceOptions& options);
SurfaceResult reconstruct_surface(std::span<const SilhouetteView> views, const SurfaceOptions& options = {});
SurfaceResult reconstruct_surface(std::span<const capture::CameraModel> cameras, std::span<const capture::Matte> mattes,
                                  const SurfaceOptions& options = {});

}  // namespace rotunda::recon
