#include "playback/motion_strand.h"

#include <algorithm>

namespace rotunda::playback {

Eigen::Vector2d place_of(const std::vector<Layer>& layers, const RootPaths& roots) {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  for (const auto& layer : layers) {
    const auto& path = roots[layer.clip];
    const auto at = static_cast<std::size_t>(layer.frame);
    const double part = layer.frame - static_cast<double>(at);
    const Eigen::Vector2d root = (1.0 - part) * path[at] + part * path[std::min(at + 1, path.size() - 1)];
    place += layer.weight * (layer.world_from_clip * root);
  }
  return place;
}

void MotionStrand::pass(const recon::Join& join, std::size_t clip) {
  tracks_.push_back({clip, static_cast<double>(join.enter), now().world_from_clip * join.pose, join.blend, 0.0});
}

void MotionStrand::move(double frames) {
  for (auto& track : tracks_) track.frame += frames;
  for (std::size_t i = 1; i < tracks_.size(); ++i) tracks_[i].blended += frames;
  while (tracks_.size() > 1 && recon::blend_weight(tracks_[1].blended, tracks_[1].blend) >= 1.0)
    tracks_.erase(tracks_.begin());
}

void MotionStrand::lay(const recon::FloorPose& world_from_world) {
  for (auto& track : tracks_) track.world_from_clip = world_from_world * track.world_from_clip;
}

std::vector<Layer> MotionStrand::layers(const recon::MotionGraph& graph, double share) const {
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const auto& track = tracks_[i];
    const double weight = i == 0 ? 1.0 : recon::blend_weight(track.blended, track.blend);
    for (auto& layer : layers) layer.weight *= 1.0 - weight;
    const auto last = static_cast<double>(graph.clips[track.clip].frames - 1);
    layers.push_back({track.clip, std::min(track.frame, last), weight * share, track.world_from_clip});
  }
  return layers;
}

}  // namespace rotunda::playback
