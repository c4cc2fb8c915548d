#pragma once
// Where an eye that follows the performer looks: the middle of the body, world, metres. It moves over the floor with
// the root, evened out over half a second so that it does not bob with each step, and keeps one height over all the
// frames.
#include "recon/video/geometry_video.h"

namespace rotunda::playback {

struct FrameRange {
  int first = 0, last = 0;  // half-open
  int count() const { return last - first; }
};

// `frame` lies within `range`, which is not empty and within the video.
Eigen::Vector3d performer_place(const recon::GeometryVideoHeader& header, const FrameRange& range, int frame);

}  // namespace rotunda::playback
