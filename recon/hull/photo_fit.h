#pragma once
// What the pictures tell of a surface that is nearly right: for every vertex the offset along its normal at which the
// cameras that see it best agree, by normalised cross-correlation of grey patches on the surface (Goesele et al. 2007),
// held to the prior (an offset of nothing, the looser the farther from a rim) and made smooth over the surface by
// quadratic relaxation (Newcombe et al. 2011: search each vertex's offsets near the smooth field, smooth the field
// near what was found, ever nearer). World frame and units. Pure; the same on any number of threads.
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "capture/camera_model.h"
#include "recon/colour/visibility.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct PhotoView {
  capture::CameraModel camera;
  cv::Mat grey;      // CV_32FC1, of the camera's size
  DepthMap surface;  // of the mesh: what hides a vertex
};

struct PhotoFitOptions {
  bool thinned = false;        // match no two neighbours: what lies between follows
  double reach = 0.016;        // world units either way
  int steps = 8;               // offsets tried either way
  int patch = 7;               // pixels a side, on the surface
  double least_cosine = 0.5;   // between normal and direction to the camera
  double noise = 2.0;          // of a grey pixel: standard deviation
  double prior_sigma = 0.008;  // of the surface beside a rim
  double prior_slope = 0.10;   // of that standard deviation by the distance to the nearest rim
  double photo_weight = 16.0;  // of a correlation that falls by one, against one sigma squared of the prior, halved
  double smoothness = 1.0;     // of a difference of one step between neighbours
};

// Depth maps are drawn from the mesh. `pictures` RGB, one a camera.
std::vector<PhotoView> photo_views(const TriangleMesh& mesh, std::span<const capture::CameraModel> cameras,
                                   std::span<const cv::Mat> pictures);

// One offset a vertex along its normal. `rim_distance`: one a vertex (rim_fit.h).
std::vector<float> photo_offsets(const TriangleMesh& mesh, std::span<const float> rim_distance,
                                 std::span<const PhotoView> views, const PhotoFitOptions& options);

}  // namespace rotunda::recon
