// A capoeira sequence of 156 frames: ginga to both sides, esquiva with a hand on the floor, meia-lua de frente, ginga.
#include "simulator/people/acts/acts.h"
#include "simulator/people/acts/stand.h"
#include "simulator/people/keyed_motion.h"

namespace rotunda::simulator::acts {
namespace {

// The low swinging step: weight on the front leg, the arm on the side that is back guards the face. `back` foot is
// behind.
Posture ginga(Side back) {
  Posture p;
  p.height = -0.15;
  p.tilt = 12.0;
  p.bend = 16.0;
  p.yaw = back == Side::right ? -16.0 : 16.0;
  p.twist = back == Side::right ? 20.0 : -20.0;
  p.nod = -2.0;
  p.arm_of(back) = {.abduction = 42.0, .flexion = 72.0, .rotation = 46.0, .elbow = 98.0, .curl = 40.0};
  p.arm_of(other(back)) = {.abduction = 44.0, .flexion = -28.0, .rotation = 0.0, .elbow = 42.0, .curl = 34.0};
  return p;
}

// Both feet side by side, knees well bent.
Posture middle() {
  Posture p;
  p.height = -0.19;
  p.tilt = 10.0;
  p.bend = 14.0;
  for (auto& leg : p.leg) leg = {.hip = 48.0, .knee = 92.0};
  for (auto& arm : p.arm) arm = {.abduction = 40.0, .flexion = 38.0, .rotation = 36.0, .elbow = 70.0, .curl = 40.0};
  return p;
}

}  // namespace

Motion capoeira(const Skeleton& skeleton, const MotionOptions& options) {
  const Posture stand = idle_posture(0.0, options.seed);
  // Esquiva: ducks low under a kick, to the left, that hand on the floor, the other before the face.
  Posture esquiva = middle();
  esquiva.height = -0.36;
  esquiva.yaw = -14.0;
  esquiva.tilt = 34.0;
  esquiva.bend = 26.0;
  esquiva.side_bend = -22.0;
  esquiva.look = -6.0;
  esquiva.nod = -6.0;
  esquiva.arm_of(Side::left) = {.abduction = 40.0, .flexion = 40.0, .rotation = 10.0, .elbow = 20.0};
  esquiva.arm_of(Side::right) = {.abduction = 36.0, .flexion = 96.0, .rotation = 60.0, .elbow = 100.0, .curl = 36.0};
  // Meia-lua de frente: the straight right leg draws a half moon from outside in.
  Posture out = ginga(Side::right), front = out, in = out;
  out.height = front.height = in.height = -0.06;
  out.yaw = 0.0;
  out.tilt = front.tilt = in.tilt = -12.0;
  out.twist = 14.0;
  out.leg_of(Side::right) = {.hip = 62.0, .abduction = 38.0, .rotation = 6.0, .knee = 12.0, .ankle = 8.0};
  front.yaw = 20.0;
  front.twist = -6.0;
  front.leg_of(Side::right) = {.hip = 88.0, .abduction = 6.0, .rotation = 4.0, .knee = 8.0, .ankle = 12.0};
  in.yaw = 44.0;
  in.twist = -22.0;
  in.leg_of(Side::right) = {.hip = 58.0, .abduction = -18.0, .rotation = 0.0, .knee = 24.0, .ankle = 4.0};
  for (Posture* p : {&out, &front, &in})
    for (const Side side : {Side::left, Side::right})
      p->arm_of(side) = {
          .abduction = 58.0, .flexion = side == Side::left ? 46.0 : 6.0, .rotation = 20.0, .elbow = 52.0, .curl = 36.0};
  const auto right_back = ginga(Side::right), left_back = ginga(Side::left), between = middle();
  return keyed_motion(skeleton,
                      {.name = "capoeira",
                       .frames = 156,
                       .keys = {{0.1, stand},
                                {0.55, between},
                                {0.95, right_back},
                                {1.40, between},
                                {1.85, left_back},
                                {2.25, between},
                                {2.75, esquiva},
                                {3.10, esquiva},
                                {3.50, right_back},
                                {3.82, out},
                                {4.04, front},
                                {4.26, in},
                                {4.70, between},
                                {5.15, left_back},
                                {5.60, between},
                                {6.10, stand}},
                       .feet = {.steps = {{Side::right, 0.25, 0.55, {0.0, -0.26}, -18.0, 0.05},
                                          {Side::right, 0.68, 0.98, {-0.42, -0.12}, -14.0, 0.05},
                                          {Side::right, 1.12, 1.42, {0.0, -0.26}, -18.0, 0.05},
                                          {Side::left, 1.56, 1.86, {-0.42, 0.10}, 14.0, 0.05},
                                          {Side::left, 2.00, 2.30, {0.06, 0.30}, 22.0, 0.05},
                                          {Side::right, 3.20, 3.48, {-0.40, -0.14}, -14.0, 0.05},
                                          {Side::right, 3.60, 4.62, {0.02, -0.24}, -16.0, 0.06, true},
                                          {Side::left, 4.86, 5.14, {-0.38, 0.12}, 14.0, 0.05},
                                          {Side::left, 5.34, 5.62, {0.0, 0.112}, 9.0, 0.05},
                                          {Side::right, 5.70, 5.96, {0.0, -0.112}, -9.0, 0.04}},
                                .pivots = {{Side::left, 3.70, 4.20, 52.0}, {Side::left, 4.30, 4.70, 20.0}}},
                       .hands = {{Side::left, 2.72, 3.12, {0.30, 0.42}, 40.0}}},
                      options.seed);
}

}  // namespace rotunda::simulator::acts
