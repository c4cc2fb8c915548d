#pragma once
// Colour of surface points from the cameras that see them (ALGORITHMS step 4; Starck, Miller, Hilton 2005, 3.1): a mean
// weighted by sampling density, the cosine between normal and viewing direction, over the views in which nothing hides
// the point. Beyond the paper: a view's weight fades out towards the matte's outline and at depth jumps, and spill is
// taken out of the rim, so that no backdrop bleeds in. World frame and units; pixels in sRGB, averaged as they are.
// Pure, and the same on any number of threads.
#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "capture/camera_model.h"
#include "capture/matte/backdrop_plate.h"
#include "capture/matte/matte.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct ColourView {
  capture::CameraModel camera;
  cv::Mat rgb;           // CV_8UC3 of the camera's size
  capture::Matte matte;  // of the camera's size
  // Linear light of the rig from that of this camera; taken after the spill, which is in the camera's own colours.
  Eigen::Matrix3d colour = Eigen::Matrix3d::Identity();
  cv::Mat clean = {};  // `rgb` without spill, where somebody has taken it out already
};

struct SurfaceColourOptions {
  double least_cosine = 0.15;     // views that look along the surface at more than 81 degrees say nothing
  double cosine_power = 1.0;      // 1 as in the paper; larger prefers the view that faces the surface
  double depth_tolerance_px = 3;  // how far behind the depth map a point may lie, in pixel footprints at its depth
  double feather_px = 3;          // weight rises from 0 at one pixel inside the outline to 1 this much further in
  int depth_downscale = 1;        // picture pixels a depth map pixel
  bool remove_spill = true;
  capture::Backdrop backdrop = capture::Backdrop::blue;
};

struct SurfaceColour {
  std::vector<Colour> colours;
  std::vector<std::uint8_t> coverage;  // 255 seen; 0 seen by no view (the colour is black then)
};

// `points` and unit `normals` of the surface that `occluder` is a mesh of (usually its own vertices or samples).
// Throws InvalidInput if the spans differ in size or a view's picture or matte is not of its camera's size.
SurfaceColour surface_colour(std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> normals,
                             const TriangleMesh& occluder, std::span<const ColourView> views,
                             const SurfaceColourOptions& options = {});

}  // namespace rotunda::recon
