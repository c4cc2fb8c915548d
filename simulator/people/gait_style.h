#pragma once
// Walking and jogging as curves over the stride. Sagittal joint angles: Winter, The Biomechanics and Motor Control of
// Human Gait, 1991 (walking, natural cadence) and Novacheck, "The biomechanics of running", Gait and Posture 7, 1998
// (jogging, the slower end). Degrees; flexion and toes up are positive. The foot's pitch against the floor is what
// these add up to, with the sole held flat between foot flat and heel off (Perry, Gait Analysis, 1992).
#include "simulator/people/posture.h"

namespace rotunda::simulator {

struct GaitStyle {
  double period;        // seconds a stride: two steps
  double speed;         // metres a second of a person of 1.75 m
  double toe_off;       // phase at which a foot leaves the floor; below 0.5 both are off it twice a stride
  double drop;          // of the pelvis against standing, metres
  double bob, highest;  // half of its rise and fall, metres; phase at which it is highest
  double swing_lift;    // of the swinging foot above what the angles give, metres
  double step_width, toe_out;
};
const GaitStyle& walking();
const GaitStyle& jogging();

// Of one leg at a phase of its own stride: 0 and 1 are its heel strike. Radians.
struct SagittalAngles {
  double hip = 0.0, knee = 0.0, ankle = 0.0;
};
SagittalAngles sagittal_angles(const GaitStyle& style, double phase);
double foot_pitch(const GaitStyle& style, double phase);

// Everything but the legs; phase 0: the left heel strikes.
Posture gait_posture(const GaitStyle& style, double phase);

}  // namespace rotunda::simulator
