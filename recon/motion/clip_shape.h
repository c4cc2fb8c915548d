#pragma once
// A clip's surfaces as coarse lattices: what cycles, heel strikes and transitions are looked for in. World, metres;
// the lattice's samples need not correspond for gait_events, and must for frame_similarity and what stands on it.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "recon/video/geometry_video.h"

namespace rotunda::recon {

struct ClipShape {
  std::string name;  // for messages
  int level = 7;
  double fps = 25.0;
  std::vector<std::vector<Eigen::Vector3f>> frames;
  std::vector<std::vector<Colour>> colours;  // at the same samples; may be empty
  std::vector<float> areas;                  // m^2 that a sample stands for, mean over the clip; border copies have 0

  int frame_count() const { return static_cast<int>(frames.size()); }
};

// At the video's level or `level`, whichever is coarser. Throws what the reader throws.
ClipShape clip_shape(GeometryVideoReader& video, const std::string& name, int level = 7);
ClipShape clip_shape(const std::vector<GeometryImage>& images, const std::string& name, int level, double fps);

// The area-weighted middle of one frame.
Eigen::Vector3d middle_of(const ClipShape& clip, int frame);

// Lattice samples that stand beside each sample (raster indices, canonical ones alone have neighbours).
std::vector<std::vector<std::uint32_t>> lattice_neighbours(int level);

}  // namespace rotunda::recon
