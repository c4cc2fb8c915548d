#pragma once
// What a character does from moment to moment: its motion graph steered by commands (ALGORITHMS step 10). No pictures
// and no clock of its own, so that a film, a test and a window go the same way. Metres, seconds, world: the floor.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "playback/motion_strand.h"
#include "playback/performance_script.h"
#include "playback/stride_phase.h"
#include "recon/motion/motion_graph.h"

namespace rotunda::playback {

struct Appearance {
  std::vector<Layer> layers;  // the last is the one that is blended in
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double heading = 0.0;  // radians
};

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
  double aim() const;                    // the heading when all turns asked for are done, radians
  double rate() const;                   // of playing, against the recording
  double companion_share() const { return companion_ ? companion_->share : 0.0; }  // of another gait, blended by speed
  const recon::MotionGraph& graph() const { return graph_; }

 private:
  // Another cycle that goes along at the same phase of the stride.
  struct Companion {
    const recon::MotionState* state = nullptr;
    MotionStrand strand;
    double share = 0.0;
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
  void play(double frames);
  void turn(double seconds);
  StridePace pace_of(const recon::MotionState& state) const;
  const recon::MotionState* wanted_companion() const;
  double wanted_share() const;
  void lead_companion(double seconds);
  void keep_phase();
  double stride_seconds() const;
  Eigen::Vector2d place(const MotionStrand& strand) const { return place_of(strand.layers(graph_, 1.0), roots_); }
  Eigen::Vector2d pivot() const;

  recon::MotionGraph graph_;
  RootPaths roots_;
  std::optional<MotionStrand> strand_;
  std::optional<Companion> companion_;
  const recon::MotionState* state_ = nullptr;
  const recon::MotionTransition* transition_ = nullptr;  // being played
  const recon::MotionTransition* action_ = nullptr;      // asked for
  std::string doing_, wanted_;
  std::optional<double> speed_;  // asked for
  double turn_left_ = 0.0;
  long seams_ = 0;
};

}  // namespace rotunda::playback
