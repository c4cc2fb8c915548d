#pragma once
// Clips laid end to end on the floor: the one that is played and those before it that still fade out. What a
// CharacterPlayer is made of; Appearance is what is seen of it. Frames are the clips', world: metres, the floor.
#include <Eigen/Core>
#include <vector>

#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

// One clip's share of what is seen.
struct Layer {
  std::size_t clip = 0;  // of the graph
  double frame = 0.0;    // between frames where the character goes faster or slower than it was recorded
  double weight = 1.0;   // of all layers together 1
  recon::FloorPose world_from_clip;
};

// The roots of every clip's frames over its floor, in the graph's order.
using RootPaths = std::vector<std::vector<Eigen::Vector2d>>;

// Where the layers' roots are together.
Eigen::Vector2d place_of(const std::vector<Layer>& layers, const RootPaths& roots);

class MotionStrand {
 public:
  struct Track {
    std::size_t clip = 0;
    double frame = 0.0;
    recon::FloorPose world_from_clip;
    int blend = 0;         // frames
    double blended = 0.0;  // frames since it began to be blended in
  };

  // Begins with one clip alone.
  MotionStrand(std::size_t clip, double frame, const recon::FloorPose& world_from_clip)
      : tracks_{{clip, frame, world_from_clip, 0, 0.0}} {}

  const Track& now() const { return tracks_.back(); }
  std::size_t track_count() const { return tracks_.size(); }
  // Another clip begins to be blended in, laid over the current one.
  void pass(const recon::Join& join, std::size_t clip);
  void move(double frames);
  void lay(const recon::FloorPose& world_from_world);

  // Weights together `share`.
  std::vector<Layer> layers(const recon::MotionGraph& graph, double share) const;

 private:
  std::vector<Track> tracks_;  // the last is current
};

}  // namespace rotunda::playback
