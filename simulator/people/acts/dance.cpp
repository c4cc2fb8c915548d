// A dance of 330 frames: 24 beats of 0.55 s. Eight beats of steps to the side with a clap, eight of rolling hips and
// waving arms, a whole spin and kicks, a pose.
#include <cmath>

#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"
#include "simulator/people/keyed_motion.h"

namespace rotunda::simulator::acts {
namespace {

constexpr double kBeat = 0.55;  // seconds: 24 beats are 330 frames

// Deep in the knees on the beat, arms swung out on the side the step goes to.
Posture side_step(Side to) {
  Posture p;
  const double s = sign_of(to);
  p.height = -0.075;
  p.list = -5.0 * s;
  p.side_bend = 10.0 * s;
  p.yaw = 8.0 * s;
  p.twist = 10.0 * s;
  p.bend = 5.0;
  p.look = 14.0 * s;
  p.head_tilt = -6.0 * s;
  p.arm_of(to) = {.abduction = 68.0, .flexion = 14.0, .rotation = 0.0, .elbow = 58.0, .curl = 30.0};
  p.arm_of(other(to)) = {.abduction = 22.0, .flexion = 34.0, .rotation = 42.0, .elbow = 84.0, .curl = 36.0};
  return p;
}

Posture clap() {
  Posture p;
  p.height = -0.02;
  p.bend = -3.0;
  p.nod = -6.0;
  for (auto& arm : p.arm)
    arm = {.abduction = 8.0, .flexion = 72.0, .rotation = 36.0, .elbow = 76.0, .curl = 8.0, .shrug = 6.0};
  return p;
}

// The hips to a side, that arm high in a wave.
Posture hips(Side to) {
  Posture p;
  const double s = sign_of(to);
  p.height = -0.06;
  p.left = 0.05 * s;
  p.list = 10.0 * s;
  p.side_bend = -18.0 * s;
  p.twist = -8.0 * s;
  p.head_tilt = 9.0 * s;
  p.look = 10.0 * s;
  p.arm_of(to) = {.abduction = 138.0,
                  .flexion = 18.0,
                  .rotation = -10.0,
                  .elbow = 38.0,
                  .pronation = 20.0,
                  .wrist = -18.0,
                  .curl = 12.0};
  p.arm_of(other(to)) = {
      .abduction = 52.0, .flexion = -8.0, .rotation = 10.0, .elbow = 40.0, .wrist = 20.0, .curl = 20.0};
  return p;
}

// Both arms above the head, the chest out.
Posture high() {
  Posture p;
  p.height = -0.01;
  p.bend = -9.0;
  p.nod = -14.0;
  for (auto& arm : p.arm)
    arm = {.abduction = 152.0, .flexion = 12.0, .rotation = -8.0, .elbow = 22.0, .wrist = -10.0, .curl = 8.0};
  return p;
}

Posture low() {
  Posture p;
  p.height = -0.24;
  p.tilt = 14.0;
  p.bend = 22.0;
  p.nod = 10.0;
  for (auto& arm : p.arm) arm = {.abduction = 26.0, .flexion = 40.0, .rotation = 40.0, .elbow = 60.0, .curl = 44.0};
  return p;
}

// Arms drawn in for the spin.
Posture spun(double yaw) {
  Posture p = clap();
  p.yaw = yaw;
  p.height = -0.035;
  p.nod = 0.0;
  for (auto& arm : p.arm) arm = {.abduction = 12.0, .flexion = 46.0, .rotation = 60.0, .elbow = 100.0, .curl = 46.0};
  return p;
}

Posture kicked(Side side) {
  Posture p = side_step(other(side));
  p.height = -0.03;
  p.tilt = -8.0;
  p.bend = 6.0;
  p.leg_of(side) = {.hip = 58.0, .abduction = 12.0, .rotation = 10.0, .knee = 14.0, .ankle = -24.0};
  return p;
}

Posture from_yaw(Posture p, double yaw) {
  p.yaw += yaw;
  return p;
}

void dance_in_steps(KeyedMotion& dance) {
  const auto key = [&](double beat, const Posture& p) { dance.keys.push_back({beat * kBeat, p}); };
  const auto step = [&](Side side, double beat, const Eigen::Vector2d& to, double yaw) {
    dance.feet.steps.push_back({side, (beat - 0.62) * kBeat, (beat - 0.06) * kBeat, to, yaw, 0.06});
  };
  for (const double start : {1.0, 5.0}) {  // left, together with a clap; right, together with a clap
    key(start, side_step(Side::left));
    key(start + 1.0, clap());
    key(start + 2.0, side_step(Side::right));
    key(start + 3.0, clap());
    step(Side::left, start, {0.0, 0.42}, 14.0);
    step(Side::right, start + 1.0, {0.0, 0.18}, -9.0);
    step(Side::right, start + 2.0, {0.0, -0.40}, -14.0);
    step(Side::left, start + 3.0, {0.0, -0.16}, 9.0);
  }
}

void dance_in_waves(KeyedMotion& dance) {
  const auto key = [&](double beat, const Posture& p) { dance.keys.push_back({beat * kBeat, p}); };
  dance.feet.steps.push_back({Side::left, 8.3 * kBeat, 8.9 * kBeat, {0.0, 0.16}, 16.0, 0.06});
  key(9.0, hips(Side::left));
  key(10.0, hips(Side::right));
  key(11.0, hips(Side::left));
  key(11.5, hips(Side::right));
  key(12.0, hips(Side::left));
  key(13.0, low());
  key(14.0, high());
  key(15.0, low());
}

// The spin: the left foot crosses, both turn, the right comes round.
void dance_in_turns(KeyedMotion& dance) {
  const auto key = [&](double beat, const Posture& p) { dance.keys.push_back({beat * kBeat, p}); };
  const auto step = [&](Side side, double from, double until, const Eigen::Vector2d& to, double yaw,
                        bool free = false) {
    dance.feet.steps.push_back({side, from * kBeat, until * kBeat, to, yaw, 0.06, free});
  };
  key(16.0, spun(-20.0));
  key(16.7, spun(90.0));
  key(17.4, spun(220.0));
  key(18.1, spun(352.0));
  key(18.7, from_yaw(high(), 360.0));
  step(Side::right, 15.9, 16.5, {0.10, -0.02}, 70.0);
  step(Side::left, 16.6, 17.2, {0.04, -0.22}, 180.0);
  step(Side::right, 17.25, 17.8, {-0.08, -0.06}, 290.0);
  step(Side::left, 17.85, 18.4, {0.0, 0.14}, 374.0);
  dance.feet.pivots = {{Side::right, 16.6 * kBeat, 17.2 * kBeat, 165.0},
                       {Side::left, 17.3 * kBeat, 17.8 * kBeat, 275.0}};
  step(Side::right, 18.5, 18.95, {0.0, -0.16}, 346.0);
  key(20.0, from_yaw(kicked(Side::right), 360.0));
  key(21.0, from_yaw(clap(), 360.0));
  key(21.7, from_yaw(kicked(Side::left), 360.0));
  step(Side::right, 19.4, 20.7, {0.0, -0.112}, 351.0, true);
  step(Side::left, 21.1, 22.4, {0.0, 0.112}, 369.0, true);
  key(22.5, from_yaw(high(), 360.0));
}

}  // namespace

Motion dance(const Skeleton& skeleton, const MotionOptions& options) {
  const Posture stand = idle_posture(0.0, options.seed);
  KeyedMotion dance{.name = "dance", .frames = 330, .keys = {{0.1, stand}}, .feet = {}, .hands = {}};
  dance_in_steps(dance);
  dance_in_waves(dance);
  dance_in_turns(dance);
  dance.keys.push_back({23.7 * kBeat, from_yaw(stand, 360.0)});
  return keyed_motion(skeleton, dance, options.seed);
}

}  // namespace rotunda::simulator::acts
