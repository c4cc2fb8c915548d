#include "playback/performer_place.h"

#include <algorithm>
#include <cmath>

namespace rotunda::playback {
namespace {

Eigen::Vector3d mean_root(const PerformerPath& path, const FrameRange& range) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = range.first; i < range.last; ++i) sum += path.root[static_cast<std::size_t>(i)];
  return sum / range.count();
}

Eigen::Vector3d place_on_frame(const PerformerPath& path, const FrameRange& range, int frame) {
  const int reach = static_cast<int>(std::lround(0.25 * path.fps));
  const FrameRange around{std::max(range.first, frame - reach), std::min(range.last, frame + reach + 1)};
  Eigen::Vector3d place = mean_root(path, around);
  place.z() = mean_root(path, range).z();
  return place + path.box.center();
}

}  // namespace

PerformerPath performer_path(const recon::GeometryVideoHeader& header) {
  return {header.root_path, header.box, header.fps};
}

Eigen::Vector3d performer_place(const PerformerPath& path, const FrameRange& range, double at) {
  const int frame = static_cast<int>(at);
  const Eigen::Vector3d before = place_on_frame(path, range, frame);
  if (at == frame || frame + 1 >= range.last) return before;
  return before + (at - frame) * (place_on_frame(path, range, frame + 1) - before);
}

}  // namespace rotunda::playback
