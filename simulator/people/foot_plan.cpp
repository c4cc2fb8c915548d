#include "simulator/people/foot_plan.h"

#include <algorithm>
#include <cmath>

#include "simulator/people/gait.h"
#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kForever = 1e6;    // seconds
constexpr double kHeelRise = 0.16;  // seconds before a foot leaves
constexpr double kPush = radians(-32.0), kStrike = radians(8.0), kRollDown = 0.09;
constexpr double kPivotPitch = radians(-9.0);
constexpr double kWeightShift = 0.18;  // seconds to take a foot's load

}  // namespace

Footwork::Footwork(const Skeleton& skeleton, const FootPlan& plan) : sole_(skeleton), pivots_(plan.pivots) {
  const double scale = leg_scale(skeleton);
  for (const Side side : {Side::left, Side::right})
    stands_[at(side)].push_back({-kForever, kForever, idle_spot(skeleton, side, 0.0)});
  for (const auto& step : plan.steps) {
    Stand& before = stands_[at(step.side)].back();
    before.until = step.lift;
    before.clearance = scale * step.clearance;
    before.free = step.free;
    stands_[at(step.side)].push_back(
        {step.land, kForever, sole_.spot_at(scale * step.to, radians(step.yaw)), 0.0, false});
  }
}

const Footwork::Stand& Footwork::stand_at(Side side, double seconds) const {
  const auto& stands = stands_[at(side)];
  std::size_t i = 0;
  while (i + 1 < stands.size() && stands[i + 1].from <= seconds) ++i;
  return stands[i];
}

FootSpot Footwork::spot(Side side, const Stand& stand, double seconds) const {
  FootSpot spot = stand.spot;
  for (const auto& pivot : pivots_)
    if (pivot.side == side && pivot.from >= stand.from && pivot.until <= stand.until)
      spot.yaw += smooth_step((seconds - pivot.from) / (pivot.until - pivot.from)) * (radians(pivot.yaw) - spot.yaw);
  return spot;
}

LegPlacement Footwork::standing(Side side, const Stand& stand, double seconds) const {
  const double rise = (seconds - stand.until + kHeelRise) / kHeelRise, down = 1.0 - (seconds - stand.from) / kRollDown;
  double pitch = kStrike * smooth_step(down) + kPush * std::pow(std::clamp(rise, 0.0, 1.0), 2);
  for (const auto& pivot : pivots_)
    if (pivot.side == side && seconds > pivot.from && seconds < pivot.until)
      pitch +=
          kPivotPitch * std::pow(std::sin(std::numbers::pi * (seconds - pivot.from) / (pivot.until - pivot.from)), 2);
  return sole_.standing(spot(side, stand, seconds), pitch);
}

LegPlacement Footwork::stepping(Side side, const Stand& from, const Stand& to, double seconds,
                                const LegPlacement& free) const {
  const double width = to.from - from.until, t = (seconds - from.until) / width;
  const LegPlacement off = standing(side, from, from.until), on = standing(side, to, to.from);
  constexpr double kStep = 0.002;
  const Vector3d off_speed = (off.ankle - standing(side, from, from.until - kStep).ankle) / kStep;
  const Vector3d on_speed = (standing(side, to, to.from + kStep).ankle - on.ankle) / kStep;
  LegPlacement leg;
  for (Eigen::Index i = 0; i < 3; ++i)
    leg.ankle[i] = hermite(t, off.ankle[i], on.ankle[i], width * off_speed[i], width * on_speed[i]);
  leg.ankle.z() += from.clearance * std::pow(std::sin(std::numbers::pi * t), 2);
  const double s = smooth_step(t);
  const double yaw_off = spot(side, from, from.until).yaw, yaw = yaw_off + s * (to.spot.yaw - yaw_off);
  leg.foot = foot_frame(yaw, kPush + s * (kStrike - kPush));
  leg.knee = {std::cos(yaw), std::sin(yaw), 0.0};
  leg.toe_bend = off.toe_bend * (1.0 - smooth_step(t / 0.4));
  leg.slack = 1.5 * std::min(seconds - from.until, to.from - seconds);
  const double clearance = 0.012 * std::pow(std::sin(std::numbers::pi * t), 2);
  if (!from.free) {
    sole_.lift_over_floor(leg, clearance);
    return leg;
  }
  constexpr double kRelease = 0.22;  // seconds in which the leg comes free and goes back to the floor's plan
  const double own = smooth_step((seconds - from.until) / kRelease) * smooth_step((to.from - seconds) / kRelease);
  leg.ankle += own * (free.ankle - leg.ankle);
  leg.foot = leg.foot.slerp(own, free.foot);
  leg.knee = ((1.0 - own) * leg.knee + own * free.knee).normalized();
  leg.slack += own;
  sole_.lift_over_floor(leg, clearance);
  return leg;
}

LegPlacement Footwork::leg(Side side, double seconds, const LegPlacement& free) const {
  const Stand& stand = stand_at(side, seconds);
  return seconds <= stand.until ? standing(side, stand, seconds) : stepping(side, stand, *(&stand + 1), seconds, free);
}

double Footwork::load(Side side, double seconds) const {
  const Stand& stand = stand_at(side, seconds);
  return std::min(smooth_step((seconds - stand.from) / kWeightShift),
                  smooth_step((stand.until - seconds) / kWeightShift));
}

Vector2d Footwork::middle(Side side, double seconds) const {
  const FootSpot spot = stand_at(side, seconds).spot;
  return 0.5 * (spot.ball + sole_.flat_ankle(spot));
}

}  // namespace rotunda::simulator
