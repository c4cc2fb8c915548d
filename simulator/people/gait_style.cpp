#include "simulator/people/gait_style.h"

#include <cmath>
#include <numbers>
#include <span>

#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Curve = std::span<const CurveKey<1>>;

constexpr CurveKey<1> kWalkHip[] = {{0.0, {20}},   {0.05, {19}}, {0.1, {16}}, {0.2, {9}},  {0.3, {1}},  {0.4, {-6}},
                                    {0.51, {-10}}, {0.6, {-5}},  {0.7, {9}},  {0.8, {19}}, {0.88, {22}}};
constexpr CurveKey<1> kWalkKnee[] = {{0.0, {4}},   {0.05, {11}}, {0.1, {17}}, {0.15, {19}}, {0.2, {17}},
                                     {0.3, {10}},  {0.4, {6}},   {0.5, {12}}, {0.55, {23}}, {0.6, {38}},
                                     {0.65, {54}}, {0.72, {64}}, {0.8, {53}}, {0.9, {19}},  {0.97, {2}}};
constexpr CurveKey<1> kWalkAnkle[] = {{0.0, {0}}, {0.05, {-5}}, {0.1, {-2}},   {0.2, {4}},   {0.3, {7}},  {0.43, {10}},
                                      {0.5, {5}}, {0.55, {-7}}, {0.63, {-19}}, {0.7, {-11}}, {0.8, {-1}}, {0.9, {1}}};
constexpr CurveKey<1> kWalkPitch[] = {{0.0, {17}},  {0.10, {0}},   {0.36, {0}},   {0.45, {-9}},
                                      {0.5, {-18}}, {0.56, {-38}}, {0.62, {-60}}, {0.68, {-70}},
                                      {0.8, {-35}}, {0.9, {4}},    {0.96, {17}}};

constexpr CurveKey<1> kJogHip[] = {{0.0, {31}}, {0.08, {28}}, {0.17, {18}}, {0.28, {3}},  {0.40, {-8}}, {0.46, {-5}},
                                   {0.55, {7}}, {0.66, {26}}, {0.78, {40}}, {0.86, {41}}, {0.94, {35}}};
constexpr CurveKey<1> kJogKnee[] = {{0.0, {14}},  {0.06, {25}}, {0.16, {41}}, {0.25, {36}}, {0.34, {22}},
                                    {0.40, {18}}, {0.48, {31}}, {0.56, {60}}, {0.65, {86}}, {0.70, {89}},
                                    {0.8, {65}},  {0.9, {26}},  {0.96, {12}}};
constexpr CurveKey<1> kJogAnkle[] = {{0.0, {6}},    {0.08, {10}}, {0.18, {21}}, {0.26, {19}}, {0.34, {0}},
                                     {0.41, {-18}}, {0.5, {-12}}, {0.65, {2}},  {0.85, {5}}};
constexpr CurveKey<1> kJogPitch[] = {{0.0, {9}},    {0.06, {0}},   {0.20, {0}},   {0.28, {-16}},
                                     {0.35, {-38}}, {0.40, {-54}}, {0.48, {-76}}, {0.60, {-84}},
                                     {0.74, {-52}}, {0.88, {2}},   {0.95, {12}}};

struct Curves {
  Curve hip, knee, ankle, pitch;
};
Curves curves_of(const GaitStyle& style) {
  if (&style == &jogging()) return {kJogHip, kJogKnee, kJogAnkle, kJogPitch};
  return {kWalkHip, kWalkKnee, kWalkAnkle, kWalkPitch};
}

double value(Curve curve, double phase) {
  return radians(periodic_curve_at<1>(curve, 1.0, phase)[0]);
}

double wave(double phase, double shift = 0.0) {  // 1 when the left heel strikes `shift` of a stride ago
  return std::cos(2.0 * std::numbers::pi * (phase - shift));
}

Posture walking_posture(double phase) {
  Posture p;
  const double forward = wave(phase, 0.02), list = wave(phase, 0.13);
  p.forward = 0.006 * wave(2.0 * phase, 0.10);
  p.left = 0.018 * wave(phase, 0.30);  // over the standing foot
  p.yaw = -4.5 * forward;              // the hip goes along with its foot, the shoulder with the other
  p.list = 3.6 * list;                 // the side that swings hangs lower
  p.tilt = 3.0 + 0.8 * wave(2.0 * phase, 0.1);
  p.twist = 10.5 * wave(phase, 0.04);
  p.side_bend = -4.2 * list;
  p.bend = 1.5 - 1.0 * wave(2.0 * phase, 0.2);
  p.nod = 3.0 + 0.7 * wave(2.0 * phase, 0.25);
  for (const Side side : {Side::left, Side::right}) {
    const double s = sign_of(side);
    ArmPosture& arm = p.arm_of(side);  // forwards with the other leg; elbow and wrist follow
    arm.flexion = 3.0 - 20.0 * s * wave(phase, 0.02);
    arm.abduction = 12.5 - 2.0 * s * wave(phase, 0.02);
    arm.elbow = 22.0 - 13.0 * s * wave(phase, 0.07);
    arm.wrist = 5.0 + 7.0 * s * wave(phase, 0.16);
    arm.pronation = 15.0 - 8.0 * s * wave(phase, 0.05);
    arm.curl = 26.0 + 4.0 * s * wave(phase, 0.16);
    arm.shrug = 0.8 * wave(2.0 * phase, 0.3);
  }
  return p;
}

Posture jogging_posture(double phase) {
  Posture p;
  const double forward = wave(phase, 0.0), list = wave(phase, 0.16);
  p.forward = 0.008 * wave(2.0 * phase, 0.0);
  p.left = 0.010 * wave(phase, 0.20);
  p.yaw = -7.0 * forward;
  p.list = 4.0 * list;
  p.tilt = 9.0 + 1.5 * wave(2.0 * phase, 0.3);
  p.twist = 19.0 * wave(phase, 0.02);
  p.side_bend = -4.0 * list;
  p.bend = 3.0 - 2.0 * wave(2.0 * phase, 0.36);
  p.nod = 5.0 + 1.5 * wave(2.0 * phase, 0.45);
  for (const Side side : {Side::left, Side::right}) {
    const double s = sign_of(side), swing = -s * wave(phase, 0.0);
    ArmPosture& arm = p.arm_of(side);
    arm.flexion = -6.0 + 29.0 * swing;
    arm.abduction = 16.0 - 3.0 * swing;
    arm.rotation = 22.0 + 14.0 * swing;  // the hand comes before the body in front
    arm.elbow = 88.0 - 8.0 * s * wave(phase, 0.06);
    arm.pronation = 8.0;
    arm.wrist = 4.0 + 6.0 * wave(2.0 * phase, 0.3);
    arm.curl = 52.0;
    arm.shrug = 1.5 * wave(2.0 * phase, 0.1);
  }
  return p;
}

}  // namespace

const GaitStyle& walking() {
  static constexpr GaitStyle kWalking{.period = 1.04,
                                      .speed = 1.15,
                                      .toe_off = 0.62,
                                      .drop = 0.026,
                                      .bob = 0.014,
                                      .highest = 0.30,
                                      .swing_lift = 0.028,
                                      .step_width = 0.088,
                                      .toe_out = 5.0};
  return kWalking;
}

const GaitStyle& jogging() {
  static constexpr GaitStyle kJogging{.period = 0.68,
                                      .speed = 1.85,
                                      .toe_off = 0.40,
                                      .drop = 0.032,
                                      .bob = 0.032,
                                      .highest = 0.45,
                                      .swing_lift = 0.02,
                                      .step_width = 0.070,
                                      .toe_out = 5.0};
  return kJogging;
}

SagittalAngles sagittal_angles(const GaitStyle& style, double phase) {
  const Curves curves = curves_of(style);
  return {value(curves.hip, phase), value(curves.knee, phase), value(curves.ankle, phase)};
}

double foot_pitch(const GaitStyle& style, double phase) {
  return value(curves_of(style).pitch, phase);
}

Posture gait_posture(const GaitStyle& style, double phase) {
  Posture posture = &style == &jogging() ? jogging_posture(phase) : walking_posture(phase);
  posture.height = style.bob * wave(2.0 * phase, 2.0 * style.highest) - style.drop;
  return posture;
}

}  // namespace rotunda::simulator
