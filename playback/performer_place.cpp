#include "playback/performer_place.h"

#include <algorithm>
#include <cmath>

namespace rotunda::playback {
namespace {

Eigen::Vector3d mean_root(const recon::GeometryVideoHeader& header, const FrameRange& range) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = range.first; i < range.last; ++i) sum += header.root_path[static_cast<std::size_t>(i)];
  return sum / range.count();
}

}  // namespace

Eigen::Vector3d performer_place(const recon::GeometryVideoHeader& header, const FrameRange& range, int frame) {
  const int reach = static_cast<int>(std::lround(0.25 * header.fps));
  const FrameRange around{std::max(range.first, frame - reach), std::min(range.last, frame + reach + 1)};
  Eigen::Vector3d place = mean_root(header, around);
  place.z() = mean_root(header, range).z();
  return place + header.box.center();
}

}  // namespace rotunda::playback
