#include "simulator/people/synthetic_performance.h"

#include <cmath>

#include "simulator/people/board_prop.h"
#include "simulator/people/fingerprint.h"

namespace rotunda::simulator {
namespace {

std::vector<JointInfo> joint_infos() {
  std::vector<JointInfo> infos;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto joint = static_cast<Joint>(i);
    const auto parent = parent_of(joint);
    infos.push_back({std::string(to_string(joint)), parent == joint ? -1 : static_cast<int>(index(parent))});
  }
  return infos;
}

}  // namespace

SyntheticPerformance::SyntheticPerformance(Person person, Motion motion)
    : person_(std::move(person)), motion_(std::move(motion)), joints_(joint_infos()) {
  figures_.push_back({person_.bind, person_.openness, std::move(person_.texture), person_.material});
}

double SyntheticPerformance::within_round(double seconds) const {
  const double round = motion_.frames * kActStep;
  return seconds - round * std::floor(seconds / round);
}

Pose SyntheticPerformance::pose_at(double seconds) const {
  return motion_.pose_at(within_round(seconds));
}

std::vector<recon::TriangleMesh> SyntheticPerformance::surfaces_at(double seconds) const {
  const double inside = within_round(seconds);
  const auto transforms = joint_transforms(person_.skeleton, motion_.pose_at(inside));
  std::vector<recon::TriangleMesh> surfaces = {skinned(person_.bind, person_.weights, transforms)};
  cloth().move(person_, transforms, inside, surfaces.front());
  if (const auto board = board_at(seconds)) surfaces.push_back(carried(figures_.back().bind, *board));
  return surfaces;
}

const ClothMotion& SyntheticPerformance::cloth() const {
  std::call_once(cloth_computed_, [&] {
    cloth_.emplace(person_, motion_.pose_at, ClothMotionOptions{motion_.frames, motion_.is_cyclic, kActStep});
  });
  return *cloth_;
}

void SyntheticPerformance::carry_board() {
  has_board_ = true;
  figures_.push_back(board_figure());
}

std::optional<Eigen::Isometry3d> SyntheticPerformance::board_at(double seconds) const {
  if (!has_board_) return std::nullopt;
  return board_pose(within_round(seconds));
}

std::vector<JointState> SyntheticPerformance::joints_at(double seconds) const {
  const Pose pose = pose_at(seconds);
  const auto centres = joint_centres(person_.skeleton, pose);
  std::vector<JointState> states;
  for (std::size_t i = 0; i < kJoints; ++i) states.push_back({centres[i], pose.rotation[i]});
  return states;
}

std::string SyntheticPerformance::fingerprint() const {
  Fingerprint print;
  add_to(print, figures_);
  for (const auto& weights : person_.weights) {
    print.add_bytes(weights.joint.data(), sizeof weights.joint);
    print.add_bytes(weights.weight.data(), sizeof weights.weight);
  }
  print.add_bytes(&kClothEdition, sizeof kClothEdition);
  for (const auto& particle : person_.cloth.particles) print.add_bytes(&particle.looseness, sizeof particle.looseness);
  // The motion is told by what it does to the joints, whatever makes it.
  for (int frame = 0; frame < motion_.frames; ++frame)
    for (const auto& [position, rotation] : joints_at(act_seconds(frame))) {
      print.add_bytes(position.data(), sizeof(double) * 3);
      print.add_bytes(rotation.coeffs().data(), sizeof(double) * 4);
    }
  for (int frame = 0; has_board_ && frame < motion_.frames; ++frame) {
    const auto board = board_pose(act_seconds(frame));
    print.add_bytes(board.data(), sizeof(double) * 16);
  }
  return print.text();
}

}  // namespace rotunda::simulator
