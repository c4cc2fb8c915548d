#pragma once
// Where an eye that follows the performer looks: the middle of the body, world, metres. It moves over the floor with
// the root, evened out over half a second so that it does not bob with each step, and keeps one height over all the
// frames.
#include <span>

#include "recon/video/geometry_video.h"

namespace rotunda::playback {

struct FrameRange {
  int first = 0, last = 0;  // half-open
  int count() const { return last - first; }
};

// Lent: where the root is in each frame, world, and the box that the body needs about it over all of them.
struct PerformerPath {
  std::span<const Eigen::Vector3d> root;
  Eigen::AlignedBox3d box;
  double fps = 25.0;
  int frame_count() const { return static_cast<int>(root.size()); }
};
PerformerPath performer_path(const recon::GeometryVideoHeader& header);

// `at` counts frames, may be a fraction and lies within `range`, which is not empty and within the path.
Eigen::Vector3d performer_place(const PerformerPath& path, const FrameRange& range, double at);

}  // namespace rotunda::playback
