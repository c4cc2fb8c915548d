#pragma once
// How the loose cloth of a person moves in an act: position-based dynamics with compliance (Müller et al. 2007;
// Macklin, Müller, Chentanez, "XPBD", 2016; small steps: Macklin et al. 2019) of the particles of a Cloth. Each is
// drawn to its place on the skinned surface by how close it sits there, has inertia, weight and drag in still air,
// keeps its distance from its neighbours and stays out of body, legs and floor. World: metres, z up, floor z = 0. Fixed
// steps in a fixed order: the same on every number of threads. Computed once, then only read.
#include <functional>
#include <vector>

#include "simulator/people/cloth.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {

inline constexpr std::uint32_t kClothEdition = 3;  // another one whenever the same cloth would move differently

struct ClothMotionOptions {
  int frames = 1;          // of the act, each of `frame_seconds`
  bool is_cyclic = false;  // the pose of frame `frames` is that of frame 0: the cloth then closes exactly too
  double frame_seconds = 0.040;
};

class ClothMotion {
 public:
  // `pose_at`: seconds in [0, frames * frame_seconds].
  ClothMotion(const Person& person, const std::function<Pose(double)>& pose_at, const ClothMotionOptions& options);

  // Moves the cloth of the skinned surface of that moment to where it is; normals anew. Any time in the act.
  void move(const Person& person, const JointTransforms& world_from_bind, double seconds,
            recon::TriangleMesh& skinned) const;

  // How far a particle is from its skinned place.
  std::vector<Eigen::Vector3f> offsets_at(double seconds) const;

  // What was left to close after the warm-up rounds of a cyclic act, spread over the round; metres.
  double closing_error() const { return closing_error_; }

 private:
  ClothMotionOptions options_;
  std::vector<std::vector<Eigen::Vector3f>> offsets_;  // by frame; of cyclic acts `frames`, of others one more
  double closing_error_ = 0.0;
};

}  // namespace rotunda::simulator
