#pragma once
// One of the simulator's own people in a motion: the skin follows the skeleton, loose cloth moves by itself.
#include <mutex>

#include "simulator/people/cloth_motion.h"
#include "simulator/people/performance.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {

class SyntheticPerformance : public Performance {
 public:
  SyntheticPerformance(Person person, Motion motion);

  const std::string& person() const override { return person_.name; }
  const std::string& act() const override { return motion_.name; }
  int frames() const override { return motion_.frames; }
  bool is_cyclic() const override { return motion_.is_cyclic; }
  const std::vector<Figure>& figures() const override { return figures_; }
  std::vector<recon::TriangleMesh> surfaces_at(double seconds) const override;
  const std::vector<JointInfo>& joints() const override { return joints_; }
  std::vector<JointState> joints_at(double seconds) const override;
  std::vector<HeelStrike> heel_strikes() const override { return motion_.heel_strikes; }
  std::optional<Eigen::Isometry3d> board_at(double seconds) const override;
  std::string fingerprint() const override;

  void carry_board();  // the calibration board becomes the second figure, on board_act.h's path

  const Skeleton& skeleton() const { return person_.skeleton; }
  Pose pose_at(double seconds) const;

 private:
  double within_round(double seconds) const;
  const ClothMotion& cloth() const;

  Person person_;
  Motion motion_;
  std::vector<Figure> figures_;
  std::vector<JointInfo> joints_;
  bool has_board_ = false;
  mutable std::once_flag cloth_computed_;  // by whoever asks for a surface first
  mutable std::optional<ClothMotion> cloth_;
};

}  // namespace rotunda::simulator
