#pragma once
// What a character does from moment to moment: its motion graph steered by commands (ALGORITHMS step 10). No pictures
// and no clock of its own, so that a film, a test and a window go the same way. Metres, seconds, world: the floor.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "playback/performance_script.h"
#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

// One clip's share of what is seen.
struct Layer {
  std::size_t clip = 0;  // of the graph
  double frame = 0.0;    // between frames where the character goes faster or slower than it was recorded
  double weight = 1.0;   // of all layers together 1
  recon::FloorPose world_from_clip;
};

struct Appearance {
  std::vector<Layer> layers;  // the last is the one that is blended in
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double heading = 0.0;  // radians
};

// The roots of every clip's frames over its floor, in the graph's order.
using RootPaths = std::vector<std::vector<Eigen::Vector2d>>;

class CharacterPlayer {
 public:
  // Begins in the graph's first state, at the world's origin, facing +x. A clip has a root a frame: InvalidInput else.
  CharacterPlayer(recon::MotionGraph graph, RootPaths roots);

  // Answered at the earliest seam on the way there. Throws InvalidInput for a state that is not there.
  void command(const Command& command);
  void advance(double seconds);

  Appearance appearance() const;
  const std::string& doing() const { return doing_; }    // the state, transition or action
  const std::string& wanted() const { return wanted_; }  // the state asked for
  bool in_state() const { return transition_ == nullptr; }
  long seams() const { return seams_; }  // begun so far, those of cycles not counted
  double rate() const;                   // of playing, against the recording
  const recon::MotionGraph& graph() const { return graph_; }

 private:
  struct Track {
    std::size_t clip = 0;
    double frame = 0.0;
    recon::FloorPose world_from_clip;
    int blend = recon::kBlendFrames;
    double blended = 0.0;  // frames since it began to be blended in
  };
  struct Seam {
    const recon::Join* join = nullptr;
    std::string clip;                                 // entered
    const recon::MotionTransition* begins = nullptr;  // a transition, or
    const recon::MotionState* arrives = nullptr;      // a state
  };

  std::size_t index_of(const std::string& clip) const;
  const recon::MotionTransition* wanted_transition() const;
  Seam next_seam() const;
  void pass(const Seam& seam);
  void move(double frames);
  void turn(double seconds);
  Eigen::Vector2d pivot() const;

  recon::MotionGraph graph_;
  RootPaths roots_;
  std::vector<Track> tracks_;  // the last is current, those before fade out
  const recon::MotionState* state_ = nullptr;
  const recon::MotionTransition* transition_ = nullptr;  // being played
  const recon::MotionTransition* action_ = nullptr;      // asked for
  std::string doing_, wanted_;
  std::optional<double> speed_;  // asked for
  double turn_left_ = 0.0;
  long seams_ = 0;
};

}  // namespace rotunda::playback
