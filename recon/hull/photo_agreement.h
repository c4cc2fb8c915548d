#pragma once
// How well pictures agree about a place of a surface: normalised cross-correlation of grey patches of its tangent
// plane, over pairs of the cameras that see it best (Goesele et al. 2007). World frame and units. Pure.
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

// Depth maps are drawn from the mesh. `pictures` RGB, one a camera.
std::vector<PhotoView> photo_views(const TriangleMesh& mesh, std::span<const capture::CameraModel> cameras,
                                   std::span<const cv::Mat> pictures);

struct PhotoAgreementOptions {
  int patch = 7;              // pixels a side, on the surface
  double least_cosine = 0.5;  // between normal and direction to the camera
  double noise = 2.0;         // of a grey pixel: standard deviation
};

struct SurfacePlace {
  Eigen::Vector3d point, normal;
};

// Fills what the views think of the place moved along its normal by each of the offsets: 1 where they agree, about 0
// where they do not. False, and nothing filled, where fewer than two views see it.
bool photo_agreement(std::span<const PhotoView> views, const SurfacePlace& place, std::span<const double> offsets,
                     const PhotoAgreementOptions& options, std::span<float> agreement);

// The same of the surface where it is, a vertex each, and 1 where two views see it, else 0. The mesh has normals.
void surface_agreement(const TriangleMesh& mesh, std::span<const PhotoView> views, const PhotoAgreementOptions& options,
                       std::span<float> agreement, std::span<float> seen);

}  // namespace rotunda::recon
