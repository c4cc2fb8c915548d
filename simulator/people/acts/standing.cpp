// idle, hands-on-hips, a-pose: acts on two standing feet.
#include <cmath>
#include <numbers>
#include <random>

#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"

namespace rotunda::simulator::acts {
namespace {

constexpr double kIdleSeconds = kIdleFrames * kActStep;

// A sum of the first harmonics of the idle's round, amplitude about 1, another one for each channel and seed.
class Sway {
 public:
  Sway(std::uint32_t seed, std::uint32_t channel) : random_(seed * 7919U + channel) {
    std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
    for (double& phase : phases_) phase = angle(random_);
  }
  double at(double seconds) const {
    const double round = 2.0 * std::numbers::pi * seconds / kIdleSeconds;
    return 0.7 * std::sin(round + phases_[0]) + 0.35 * std::sin(2.0 * round + phases_[1]) +
           0.12 * std::sin(3.0 * round + phases_[2]);
  }

 private:
  std::mt19937 random_;
  std::array<double, 3> phases_{};
};

}  // namespace

Posture idle_posture(double seconds, std::uint32_t seed) {
  const auto sway = [&](std::uint32_t channel) { return Sway(seed, channel).at(seconds); };
  const double breath = std::sin(2.0 * std::numbers::pi * seconds / kIdleSeconds);
  Posture p;
  p.height = -0.008 + 0.001 * breath;
  p.forward = 0.010 + 0.005 * sway(1);  // the weight is a little before the ankles
  p.left = 0.016 * sway(2);             // from one leg to the other
  p.list = 1.3 * sway(2);
  p.side_bend = -1.6 * sway(2);
  p.yaw = 1.2 * sway(3);
  p.tilt = 1.0;
  p.bend = 1.0 - 0.9 * breath + 0.5 * sway(4);
  p.twist = 1.5 * sway(5);
  p.look = 5.0 * sway(6);
  p.nod = 2.0 + 1.6 * sway(7);
  p.head_tilt = 1.5 * sway(8);
  for (const Side side : {Side::left, Side::right}) {
    const auto own = static_cast<std::uint32_t>(10 + 10 * at(side));
    ArmPosture& arm = p.arm_of(side);
    arm.abduction += 0.5 * breath + 0.5 * sway(own);
    arm.flexion += 1.2 * sway(own + 1);
    arm.elbow += 2.0 * sway(own + 2) + 0.8 * breath;
    arm.wrist += 2.5 * sway(own + 3);
    arm.curl += 3.0 * sway(own + 4);
    arm.shrug = 1.0 * breath;
  }
  return p;
}

std::array<LegPlacement, 2> idle_legs(const Skeleton& skeleton, double x) {
  const Sole sole(skeleton);
  return {sole.standing(idle_spot(skeleton, Side::left, x), 0.0),
          sole.standing(idle_spot(skeleton, Side::right, x), 0.0)};
}

Pose standing_pose(const Skeleton& skeleton, const Posture& posture, const Eigen::Vector2d& place,
                   const std::array<LegPlacement, 2>& legs) {
  const double scale = leg_scale(skeleton);
  const Eigen::Vector2d aside =
      Eigen::Rotation2Dd(radians(posture.yaw)) * Eigen::Vector2d(posture.forward, posture.left) * scale;
  const double height = standing_height(skeleton) + scale * posture.height;
  Pose pose = trunk_pose(skeleton, posture, {place.x() + aside.x(), place.y() + aside.y(), height});
  stand_on(skeleton, pose, legs);
  return pose;
}

Motion idle(const Skeleton& skeleton, const MotionOptions& options) {
  return {"idle", kIdleFrames, true, {}, [skeleton, seed = options.seed](double seconds) {
            return standing_pose(skeleton, idle_posture(seconds, seed), {0.0, 0.0}, idle_legs(skeleton));
          }};
}

// Palms on the hips, elbows out: between arm and trunk one can look through, the surface has handles.
Motion hands_on_hips(const Skeleton& skeleton, const MotionOptions& options) {
  const auto pose_at = [skeleton, seed = options.seed](double seconds) {
    Pose pose = standing_pose(skeleton, idle_posture(seconds, seed), {0.0, 0.0}, idle_legs(skeleton));
    const double k = skeleton.height / 1.75;
    const Eigen::Isometry3d world_from_pelvis = joint_transforms(skeleton, pose)[index(Joint::pelvis)];
    const Eigen::Quaterniond pelvis(world_from_pelvis.linear());
    for (const Side side : {Side::left, Side::right}) {
      const double s = sign_of(side);
      const Eigen::Vector3d wrist(-0.030 * k, s * 0.205 * k, 1.020 * k), fingers(0.85, -s * 0.30, -0.42);
      place_hand(skeleton, pose, side,
                 {.wrist = world_from_pelvis * wrist,
                  .hand = pelvis * hand_towards(skeleton, side, fingers, Eigen::Vector3d(0.3, -s, 0.0)),
                  .elbow = pelvis * Eigen::Vector3d(-0.45, s, 0.1)});
    }
    return pose;
  };
  return {"hands-on-hips", kIdleFrames, true, {}, pose_at};
}

Motion a_pose(const Skeleton& skeleton, const MotionOptions&) {
  return {"a-pose", 1, true, {}, [skeleton](double) { return bind_pose(skeleton); }};
}

}  // namespace rotunda::simulator::acts
