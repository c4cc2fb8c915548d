#pragma once
// Colours of a mesh's own vertices at live quality, for ten views and 10 000 vertices in a few milliseconds. As
// colour/surface_colour.h, with three things simpler: pictures are the half-size ones of the live key; what hides a
// vertex is found among the vertices themselves (those that face the camera, the nearest one in each cell of a grid of
// their own spacing); and pixels beside the matte's outline, which have spill in them, are left to other views: where
// no other sees the place, the backdrop's channel is held to the others. World frame and units. Pure, and the same on
// any number of threads.
#include <span>

#include "capture/matte/backdrop_plate.h"
#include "capture/matte/live_key.h"
#include "recon/live/live_silhouette.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct PaintView {
  const LiveSilhouette* view = nullptr;
  const capture::HalfMatte* matte = nullptr;
  // Linear light of the rig from that of this camera.
  Eigen::Matrix3d colour = Eigen::Matrix3d::Identity();
};

// Fills `mesh.colours`; vertices that no view sees take the colour of the nearest one that is seen, along the edges.
// Throws InvalidInput for a mesh without normals.
void paint_live(TriangleMesh& mesh, std::span<const PaintView> views, capture::Backdrop backdrop);

}  // namespace rotunda::recon
