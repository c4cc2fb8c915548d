#pragma once
// A surface that was fitted to rims goes to where the pictures agree (photo_fit.h), four times, each from nearer by,
// once more from where that left lumps, evened out, and back to the rims, which know better. A repeated pattern agrees
// in wrong places too, so the fitted surface is left only for what is better than it: offsets that are told apart from
// others, of which neighbours are sure together, and after which the pictures agree no less than before. World frame
// and units. Pure; the same on any number of threads.
#include <opencv2/core.hpp>
#include <span>

#include "recon/hull/rim_fit.h"
#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

struct PhotoMatch {
  std::span<const capture::CameraModel> cameras;
  std::span<const cv::Mat> pictures;  // RGB, one a camera
  std::span<const Rim> rims;
  const TriangleMesh& hull;  // `mesh` before it was fitted to the rims: same triangles, with normals
  RimFitOptions fit;         // as it was fitted
  double metre = 1.0;        // as rims.h has it
};

// Moves positions. Same triangles.
void match_to_pictures(TriangleMesh& mesh, const PhotoMatch& match);

}  // namespace rotunda::recon
