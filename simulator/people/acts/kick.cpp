// kick and turn: from a stand to a stand.
#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"
#include "simulator/people/keyed_motion.h"

namespace rotunda::simulator::acts {
namespace {

Posture guard() {
  Posture p = idle_posture(0.0, 1);
  p.height = -0.045;
  p.bend = 5.0;
  for (auto& arm : p.arm)
    arm = {.abduction = 14.0,
           .flexion = 42.0,
           .rotation = 28.0,
           .elbow = 108.0,
           .pronation = 10.0,
           .wrist = 0.0,
           .curl = 66.0};
  return p;
}

}  // namespace

// A front kick of the right leg: guard, chamber, snap, chamber, back to the stand.
Motion kick(const Skeleton& skeleton, const MotionOptions& options) {
  const Posture stand = idle_posture(0.0, options.seed);
  Posture ready = guard(), chamber = guard(), snap = guard();
  ready.yaw = 6.0;
  ready.leg_of(Side::right) = {.hip = 15.0, .knee = 40.0};
  chamber.yaw = 10.0;
  chamber.tilt = -6.0;
  chamber.bend = 10.0;
  chamber.leg_of(Side::right) = {.hip = 88.0, .abduction = 2.0, .rotation = 2.0, .knee = 118.0, .ankle = -15.0};
  snap.yaw = 22.0;
  snap.tilt = -18.0;
  snap.bend = 12.0;
  snap.twist = -8.0;
  snap.height = -0.03;
  snap.leg_of(Side::right) = {.hip = 84.0, .abduction = 0.0, .rotation = 4.0, .knee = 8.0, .ankle = -28.0};
  snap.arm_of(Side::right) = {.abduction = 24.0, .flexion = -18.0, .rotation = 10.0, .elbow = 42.0, .curl = 62.0};
  Posture recoil = chamber;
  recoil.yaw = 12.0;
  recoil.leg_of(Side::right).knee = 105.0;
  return keyed_motion(
      skeleton,
      {.name = "kick",
       .frames = 80,
       .keys = {{0.1, stand}, {0.6, ready}, {0.95, chamber}, {1.18, snap}, {1.42, recoil}, {2.1, ready}, {2.9, stand}},
       .feet = {.steps = {{Side::right, 0.62, 2.0, {0.0, -0.112}, -9.0, 0.05, true}},
                .pivots = {{Side::left, 0.85, 1.2, 34.0}, {Side::left, 1.5, 2.0, 9.0}}}},
      options.seed);
}

// Half a turn to the left on the spot; the head leads.
Motion turn(const Skeleton& skeleton, const MotionOptions& options) {
  const Posture stand = idle_posture(0.0, options.seed);
  const auto turned = [&](double yaw, double look, double twist) {
    Posture p = stand;
    p.yaw += yaw;
    p.look = look;
    p.twist = twist;
    p.height -= 0.012;
    return p;
  };
  Posture end = stand;
  end.yaw += 180.0;
  return keyed_motion(skeleton,
                      {.name = "turn",
                       .frames = 70,
                       .keys = {{0.05, stand},
                                {0.40, turned(12, 30, 10)},
                                {0.80, turned(62, 38, 9)},
                                {1.25, turned(118, 34, 7)},
                                {1.75, turned(168, 12, 2)},
                                {2.35, end}},
                       .feet = {.steps = {{Side::left, 0.38, 0.78, {-0.06, 0.10}, 72.0, 0.045},
                                          {Side::right, 0.88, 1.28, {0.10, 0.06}, 112.0, 0.045},
                                          {Side::left, 1.36, 1.72, {0.0, -0.112}, 189.0, 0.04},
                                          {Side::right, 1.80, 2.12, {0.0, 0.112}, 171.0, 0.035}}}},
                      options.seed);
}

}  // namespace rotunda::simulator::acts
