#include "simulator/people/gait.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kForever = 1e6;  // seconds
constexpr double kRounding = 1e-9;
constexpr double kClearance = 0.014;                   // of a swinging foot at the least (Winter 1991: 13 mm), metres
constexpr double kClearing = 0.07;                     // seconds after toe-off in which it gets there
constexpr double kFlat = 0.4;                          // part of the stance at which the sole is flat in every gait
constexpr double kFirstPush = 0.6, kLastStrike = 0.5;  // of a full step's foot pitch, from and to a stand

// Phase of a style at a part of the stance (0 to 1) or of the swing (1 to 2).
double style_phase(const GaitStyle& style, double part) {
  return part <= 1.0 ? part * style.toe_off : style.toe_off + (part - 1.0) * (1.0 - style.toe_off);
}

// Ankle (x, z) under the hip by the joint angles alone.
Vector2d hanging_ankle(const Skeleton& skeleton, const GaitStyle& style, double phase) {
  const SagittalAngles angles = sagittal_angles(style, phase);
  const double shank = angles.hip - angles.knee;
  return {skeleton.thigh_length() * std::sin(angles.hip) + skeleton.shank_length() * std::sin(shank),
          -skeleton.thigh_length() * std::cos(angles.hip) - skeleton.shank_length() * std::cos(shank)};
}

// Where the flat foot's ankle is against the pelvis at mid-stance, so that over the stance the joint angles fit best.
double mid_stance(const Skeleton& skeleton, const Sole& sole, const GaitStyle& style) {
  constexpr int kSamples = 50;
  const double travelled = leg_scale(skeleton) * style.speed * style.period;  // a stride
  double sum = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double phase = style.toe_off * (i + 0.5) / kSamples, pitch = foot_pitch(style, phase);
    sum += hanging_ankle(skeleton, style, phase).x() - sole.ankle_at(pitch).x() +
           travelled * (phase - 0.5 * style.toe_off);
  }
  return sum / kSamples;
}

}  // namespace

double Ramp::at(double seconds) const {
  return from + (to - from) * smooth_step((seconds - start) / (end - start));
}

double Ramp::integral(double seconds) const {
  const double width = end - start, t = std::clamp((seconds - start) / width, 0.0, 1.0);
  const double after = std::max(0.0, seconds - end);
  return from * seconds + (to - from) * (width * t * t * t * (1.0 - 0.5 * t) + after);
}

GaitCourse steady(const GaitStyle& style) {
  const auto constant = [](double value) { return Ramp{.from = value, .to = value}; };
  GaitCourse course;
  course.cadence = constant(1.0 / style.period);
  course.speed = constant(style.speed);
  course.jogging = constant(&style == &jogging() ? 1.0 : 0.0);
  return course;
}

FootSpot idle_spot(const Skeleton& skeleton, Side side, double x) {
  const double s = sign_of(side);
  return Sole(skeleton).spot_at({x, s * 0.112 * leg_scale(skeleton)}, s * radians(9.0));
}

Gait::Gait(const Skeleton& skeleton, const GaitCourse& course, double begin, double end)
    : skeleton_(skeleton), sole_(skeleton), scale_(leg_scale(skeleton)), course_(course) {
  for (const Side side : {Side::left, Side::right}) plan(side, begin, end);
}

double Gait::phase(double seconds) const {
  return course_.phase + course_.cadence.integral(seconds);
}

double Gait::distance(double seconds) const {
  return course_.x + scale_ * course_.speed.integral(seconds);
}

Posture Gait::posture(double seconds) const {
  const double now = phase(seconds);
  return blend(gait_posture(walking(), now), gait_posture(jogging(), now), blend_at(seconds).jogging);
}

// The phase only grows; Newton's steps on it.
double Gait::time_of_phase(double wanted) const {
  double seconds = (wanted - course_.phase) / course_.cadence.from;
  for (int i = 0; i < 60; ++i) seconds -= (phase(seconds) - wanted) / course_.cadence.at(seconds);
  return seconds;
}

Gait::Contact Gait::contact(Side side, double strike) const {
  const double s = sign_of(side);
  Contact contact;
  contact.phase = strike;
  contact.on = time_of_phase(strike);
  const Blend blend = blend_at(contact.on);
  const double stance = blend.between(walking().toe_off, jogging().toe_off);
  contact.off = time_of_phase(strike + stance);
  const double ahead = blend.between(mid_stance(skeleton_, sole_, walking()), mid_stance(skeleton_, sole_, jogging()));
  const double width = scale_ * blend.between(walking().step_width, jogging().step_width);
  const double toe_out = radians(blend.between(walking().toe_out, jogging().toe_out));
  const double middle = contact.on > kRounding  // else planned before anything changed
                            ? distance(time_of_phase(strike + 0.5 * stance))
                            : distance(contact.on) + scale_ * course_.speed.from * 0.5 * stance / course_.cadence.from;
  const double x = middle + ahead;
  contact.spot = sole_.spot_at({x, s * width}, s * toe_out);
  return contact;
}

void Gait::plan(Side side, double begin, double end) {
  auto& contacts = contacts_[at(side)];
  const double shift = side == Side::left ? 0.0 : 0.5;
  const double first = std::floor(phase(begin) - shift) - 1.0, last = std::floor(phase(end) - shift) + 2.0;
  for (double k = first; k <= last; k += 1.0) contacts.push_back(contact(side, k + shift));
  if (course_.stands_until) {
    while (contacts.front().off < *course_.stands_until) contacts.erase(contacts.begin());
    contacts.front().on = -kForever;
    contacts.front().spot = idle_spot(skeleton_, side, distance(begin));
    contacts.front().from_standing = true;
  }
  if (course_.stands_from) {
    while (contacts.back().on > *course_.stands_from) contacts.pop_back();
    contacts.back().off = kForever;
    contacts.back().spot = idle_spot(skeleton_, side, distance(end));
    contacts.back().to_standing = true;
  }
}

double Gait::toe_off(const Contact& contact) const {
  return blend_at(contact.on).between(walking().toe_off, jogging().toe_off);
}

double Gait::pitch(const Contact& contact, double seconds) const {
  const double own = phase(seconds) - contact.phase, stance = toe_off(contact);
  double part = own <= stance ? own / stance : 1.0 + (own - stance) / (1.0 - stance);
  if (contact.from_standing) part = std::max(part, kFlat);
  if (contact.to_standing) part = std::min(part, kFlat);
  const double pitch = blend_at(seconds).between(foot_pitch(walking(), style_phase(walking(), part)),
                                                 foot_pitch(jogging(), style_phase(jogging(), part)));
  const double effort = contact.from_standing ? kFirstPush + (1.0 - kFirstPush) * smooth_step(part - 1.0) : 1.0;
  return pitch * (contact.to_standing ? kLastStrike : effort);
}

LegPlacement Gait::stance(const Contact& contact, double seconds) const {
  return sole_.standing(contact.spot, pitch(contact, seconds));
}

Vector2d Gait::free_ankle(const Contact& contact, double seconds, double pelvis_height) const {
  const double own = phase(seconds) - contact.phase, stance = toe_off(contact);
  const double part = own <= stance ? own / stance : 1.0 + (own - stance) / (1.0 - stance);
  const Vector2d walk = hanging_ankle(skeleton_, walking(), style_phase(walking(), part));
  const Vector2d jog = hanging_ankle(skeleton_, jogging(), style_phase(jogging(), part));
  const double hip =
      pelvis_height + skeleton_.joint[index(Joint::thigh_left)].z() - skeleton_.joint[index(Joint::pelvis)].z();
  return Vector2d(distance(seconds), hip) + walk + blend_at(seconds).jogging * (jog - walk);
}

// What the angles leave open against the floor is made up exactly in stance and runs out smoothly over the swing.
LegPlacement Gait::swing(const Contact& from, const Contact& to, double seconds, double pelvis_height) const {
  const double width = to.on - from.off, t = (seconds - from.off) / width, s = 1.0 - t;
  const auto error = [&](const Contact& contact, double when) -> Vector2d {
    const Vector3d ankle = stance(contact, when).ankle;
    return Vector2d(ankle.x(), ankle.z()) - free_ankle(from, when, pelvis_height);
  };
  const auto fading = [&](double after) {  // starts with slope 1: carries the speed over between stance and swing
    const double rest = std::max(0.0, 1.0 - after / (0.32 * width));
    return after * rest * rest;
  };
  constexpr double kStep = 0.002;
  const Vector2d off = error(from, from.off), on = error(to, to.on);
  const Vector2d off_slope = (off - error(from, from.off - kStep)) / kStep;
  const Vector2d on_slope = (error(to, to.on + kStep) - on) / kStep;
  const double lift = scale_ * blend_at(seconds).between(walking().swing_lift, jogging().swing_lift) *
                      std::pow(std::sin(std::numbers::pi * t), 2);
  const Vector2d ankle = free_ankle(from, seconds, pelvis_height) + s * s * (1.0 + 2.0 * t) * off +
                         t * t * (3.0 - 2.0 * t) * on + fading(seconds - from.off) * off_slope -
                         fading(to.on - seconds) * on_slope + Vector2d(0.0, lift);
  const double yaw = from.spot.yaw + smooth_step(t) * (to.spot.yaw - from.spot.yaw);
  const double y_off = stance(from, from.off).ankle.y(), y_on = stance(to, to.on).ankle.y();
  const double landing = to.to_standing ? 1.0 + (kLastStrike - 1.0) * smooth_step(t) : 1.0;
  const double pitch_now = pitch(from, seconds) * landing;
  LegPlacement leg;
  leg.ankle = {ankle.x(), y_off + smooth_step(t) * (y_on - y_off), ankle.y()};
  leg.foot = foot_frame(yaw, pitch_now);
  leg.knee = {std::cos(yaw), std::sin(yaw), 0.0};
  leg.toe_bend = std::max(0.0, -pitch_now) * (1.0 - smooth_step((t - 0.1) / 0.4));  // the toes straighten
  leg.slack = 1.2 * std::min(seconds - from.off, to.on - seconds);
  const double clear = smooth_step((seconds - from.off) / kClearing) * smooth_step((to.on - seconds) / (0.5 * width));
  sole_.lift_over_floor(leg, scale_ * kClearance * clear);
  return leg;
}

std::array<LegPlacement, 2> Gait::legs(double seconds, double pelvis_height) const {
  std::array<LegPlacement, 2> legs;
  for (const Side side : {Side::left, Side::right}) {
    const auto& contacts = contacts_[at(side)];
    std::size_t i = 0;
    while (i + 1 < contacts.size() && contacts[i + 1].on <= seconds) ++i;
    legs[at(side)] = seconds <= contacts[i].off ? stance(contacts[i], seconds)
                                                : swing(contacts[i], contacts[i + 1], seconds, pelvis_height);
  }
  return legs;
}

std::vector<HeelStrike> Gait::heel_strikes(double begin, double end) const {
  std::vector<HeelStrike> strikes;
  for (const Side side : {Side::left, Side::right})
    for (const auto& contact : contacts_[at(side)])
      if (contact.on >= begin - kRounding && contact.on < end - kRounding)
        strikes.push_back({std::max(begin, contact.on), side});
  std::sort(strikes.begin(), strikes.end(), [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  return strikes;
}

}  // namespace rotunda::simulator
