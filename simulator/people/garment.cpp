#include "simulator/people/garment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulator/people/garment_cut.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kTurnUp = 0.088;  // height of the trousers' hem
constexpr double kEdge = 0.005;    // metres that a cloth's colour goes round its edge
constexpr double kFar = 0.40;      // no cloth is farther from the body

double hem_of(const Top& top, const Vector3d& q) {
  const double side = std::sin(std::atan2(q.y(), q.x() + 0.01));
  return top.hem - top.hem_dip * (1.0 - side * side);
}

// How far the front is open at a height: a wedge from `open_from` down to the hem.
double front_opening(const Top& top, const Vector3d& q) {
  if (top.opening <= 0.0 || q.x() < 0.0) return -1.0;
  const double half = top.opening * (top.open_from - q.z()) / (top.open_from - top.hem);
  return half - std::abs(q.y());
}

// Cloth gathers across the inside of the elbow, about the waist, and hangs in long folds to the hem.
double folds(const Top& top, const ArmPlace& arm, const Vector3d& q, std::uint32_t seed) {
  if (arm.beyond > 0.0) {
    const double at_elbow = std::exp(-std::pow((arm.along - kElbow) / 0.07, 2));
    const double round = std::atan2(q.x() + 0.014, q.z() - 1.419 + std::abs(q.y()) - 0.18);
    const double ring = solid_noise(Vector3d(arm.along / 0.020, round * 0.8, 3.0 * (q.y() > 0 ? 1 : -1)), seed + 5);
    return (0.25 + 1.1 * at_elbow) * ring * std::min(0.45 * top.cuff, 0.006);
  }
  const double at_waist = std::exp(-std::pow((q.z() - 1.07) / 0.06, 2)), low = ramp(-q.z(), -1.15, -top.hem);
  const double angle = std::atan2(q.y(), q.x());
  const double across = solid_noise(
      Vector3d(q.z() / 0.022 + 0.7 * std::sin(2 * angle), std::cos(angle) * 1.6, std::sin(angle) * 1.6), seed + 6);
  const double hanging = solid_noise(Vector3d(std::cos(angle) * 3.2, std::sin(angle) * 3.2, q.z() / 0.22), seed + 7);
  return std::min(0.45 * top.waist, 0.006) * at_waist * across + std::min(0.7 * top.hip, 0.016) * low * hanging;
}

double stands_off(const Top& top, const ArmPlace& arm, const Vector3d& q) {
  if (arm.beyond > 0.0) return top.chest + (top.cuff - top.chest) * ramp(arm.along, 0.10, top.sleeve);
  const double to_waist = ramp(-q.z(), -1.30, -1.08), to_hip = ramp(-q.z(), -1.08, -0.92);
  return top.chest + (top.waist - top.chest) * to_waist + (top.hip - top.waist) * to_hip;
}

double top_distance(const Top& top, const Vector3d& q, double body, std::uint32_t seed) {
  const ArmPlace arm = arm_place(q);
  const double cloth = body - stands_off(top, arm, q) - folds(top, arm, q, seed);
  const double sleeve = std::min(arm.beyond, arm.along - top.sleeve);
  const double trunk = std::max(hem_of(top, q) - q.z(), neckline(top, q));
  return smooth_max(cloth, std::max({sleeve, trunk, front_opening(top, q)}), 0.004);
}

// What of the neck a collar covers: it is laid open in front, where lapels may take its place. Negative inside.
double collar_band(const Vector3d& q, bool has_lapels) {
  const Vector3d a(-0.028, 0.0, 1.435), b(-0.012, 0.0, 1.498);
  const double side = std::hypot(q.x() + 0.022, q.y()) - 0.100;
  const double front = std::max(0.0, q.x() + 0.02);
  const double above = (q - b).dot((b - a).normalized()) + 0.30 * front;
  const double below = 1.468 - 0.30 * front - q.z();  // its points hang lower
  double open = q.x() > 0.0 ? 0.8 * (0.004 + 0.40 * (1.490 - q.z()) - std::abs(q.y())) : -1.0;
  if (has_lapels) open = 0.8 * (q.x() - 0.010);
  return std::max({side, above, below, open});
}

// Folded over: it lies on the shirt by its own double thickness.
double collar_distance(const Vector3d& q, double body, double chest, bool has_lapels) {
  constexpr double kFold = 0.006;
  return smooth_max(body - chest - kFold, collar_band(q, has_lapels), 0.002);
}

double trousers_distance(const Cut& cut, const Vector3d& q, double body, std::uint32_t seed) {
  const double low = ramp(-q.z(), -0.45, -0.12);
  const double at_knee = std::exp(-std::pow((q.z() - 0.50) / 0.07, 2));
  const double at_ankle = std::exp(-std::pow((q.z() - 0.14) / 0.06, 2));
  const double ring = solid_noise(Vector3d(q.x() / 0.07, q.y() / 0.07, q.z() / 0.020), seed + 8);
  const double off = cut.trouser_leg * (0.4 + 0.6 * low) + (0.0045 * at_knee + 0.006 * at_ankle) * ring;
  const double waist = q.z() - 0.98, instep = q.x() - cut.instep;  // the shoe comes out in front
  const double before_shoe = q.z() < 0.14 ? instep : -1.0;
  return smooth_max(body - off, std::max({kTurnUp - q.z(), waist, before_shoe, arm_place(q).beyond}), 0.004);
}

double bell_distance(const Bell& bell, const BellPlace& place, const Vector3d& q) {
  double d = smooth_max(place.outside, place.underside, 0.003);
  d = smooth_max(d, q.z() - bell.top, 0.02);
  if (bell.slit > 0.0 && q.x() > 0.0) {
    const double half = bell.slit * ramp(-q.z(), -0.92, -bell.hem);
    const double deep = 0.055 + place.outside;
    d = smooth_max(d, std::min(half - std::abs(q.y()), deep), 0.006);
  }
  return d;
}

bool has_collar(Outfit outfit) {
  return outfit == Outfit::loose_shirt || outfit == Outfit::coat;
}

}  // namespace

Garments::Garments(Outfit outfit, double girth, std::uint32_t seed) : outfit_(outfit), girth_(girth), seed_(seed) {}

double Garments::distance(const Vector3d& q, double body) const {
  if (body > kFar) return body;
  const Cut& cut = cut_of(outfit_);
  double d = smooth_min(body, top_distance(cut.top, q, body, seed_), 0.003);
  if (cut.trouser_leg > 0.0 && q.z() < 1.02) d = smooth_min(d, trousers_distance(cut, q, body, seed_), 0.003);
  if (has_collar(outfit_) && q.z() > 1.38)
    d = smooth_min(d, collar_distance(q, body, cut.top.chest, cut.bell.has_value()), 0.002);
  if (!cut.bell || q.z() > cut.bell->top + 0.1 || q.z() < cut.bell->hem - 0.1) return d;
  return smooth_min(d, bell_distance(*cut.bell, bell_place(*cut.bell, girth_, seed_, q), q), 0.010);
}

GarmentPlace Garments::place_of(const Vector3d& q) const {
  const Cut& cut = cut_of(outfit_);
  const ArmPlace arm = arm_place(q);
  GarmentPlace place;
  if (q.z() > kThroat) return place;
  const bool on_arm = arm.beyond > 0.0;
  if (on_arm) {
    if (arm.along < cut.top.sleeve + kEdge) place.garment = cut.top.garment;
    return place;
  }
  if (cut.bell && q.z() < cut.bell->top && q.z() > cut.bell->hem - 0.01) {
    const BellPlace bell = bell_place(*cut.bell, girth_, seed_, q);
    const double hangs = 0.55 * ramp(bell.down, 0.25, 1.0), left = ramp(q.y(), -0.10, 0.10);
    if (bell.underside > -0.012 && bell.radius < 0.95) {
      place.garment = Garment::lining;
    } else if (bell.radius > 0.9 || bell.down < 0.5) {
      place.garment = cut.top.garment == Garment::coat ? Garment::coat : Garment::skirt;
    }
    if (place.garment != Garment::bare) {
      place.left_thigh = hangs * left;
      place.right_thigh = hangs * (1.0 - left);
      return place;
    }
  }
  const double over_hem = std::min(kEdge, 0.3 * cut.top.hip), over_neck = std::min(kEdge, 0.3 * cut.top.chest);
  const bool is_shirt = cut.top.garment == Garment::shirt && q.z() > 1.38 && q.z() < 1.47;
  const bool collared =
      is_shirt || (has_collar(outfit_) && q.z() > 1.42 && q.z() < 1.52 && collar_band(q, cut.bell.has_value()) < 0.004);
  if (collared || (neckline(cut.top, q) < over_neck && q.z() > hem_of(cut.top, q) - over_hem &&
                   front_opening(cut.top, q) < over_hem))
    place.garment = cut.top.garment;
  else if (outfit_ == Outfit::coat && q.z() > hem_of(cut.top, q) && round_neck(cut.top, q) < 0.0)
    place.garment = Garment::undershirt;
  else if (cut.trouser_leg > 0.0 && q.z() < 1.0 && q.z() > kTurnUp - 0.004)
    place.garment = Garment::trousers;
  return place;
}

double Garments::looseness(const Vector3d& q) const {
  const Cut& cut = cut_of(outfit_);
  const GarmentPlace place = place_of(q);
  const ArmPlace arm = arm_place(q);
  switch (place.garment) {
    case Garment::shirt:
      if (arm.beyond > 0.0) return 0.35 * ramp(arm.along, 0.06, 0.20);
      return 0.75 * ramp(-q.z(), -1.30, -cut.top.hem);
    case Garment::coat:
      if (arm.beyond > 0.0) return 0.30 * ramp(arm.along, 0.08, 0.40);
      return ramp(-q.z(), -1.25, -cut.bell->hem);
    case Garment::skirt:
      return ramp(-q.z(), -cut.bell->top + 0.03, -cut.bell->hem);
    case Garment::bare:
    case Garment::tee:
    case Garment::trousers:
    case Garment::bodice:
    case Garment::undershirt:
    case Garment::lining:
      break;
  }
  return 0.0;
}

double Garments::reach() const {
  const Cut& cut = cut_of(outfit_);
  return cut.bell ? girth_ * std::max(cut.bell->depth_hem, cut.bell->width_hem) + cut.bell->pleat_height + 0.03 : 0.0;
}

}  // namespace rotunda::simulator
