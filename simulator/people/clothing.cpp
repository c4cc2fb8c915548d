#include "simulator/people/clothing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulator/people/garment_colour.h"
#include "simulator/people/garment_cut.h"
#include "simulator/people/paint.h"
#include "simulator/people/skin_colour.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using namespace paint;
using Eigen::Vector3d;

struct Spot {
  const Clothing& clothing;
  Vector3d p;  // person frame, metres, scaled to a height of 1.75 m
  BodyPlace place;
  std::uint32_t seed;
  double grain(double size, std::uint32_t channel) const { return solid_noise(p / size, seed + channel); }
};

bool on_trunk(const Spot& spot) {
  const Joint j = spot.place.joint;
  return j == Joint::pelvis || j == Joint::spine || j == Joint::chest || j == Joint::neck;
}

Vector3d plaid(const Spot& spot, const Eigen::Vector2d& uv) {
  const Clothing& wear = spot.clothing;
  const double period = wear.check;
  double dark = 0.0, light = 0.0;
  for (const double x : {uv.x(), uv.y()}) {
    dark += 0.5 * band(from_line(x, period), 0.26 * period, 0.003);
    light = std::max(light, band(from_line(x - 0.5 * period, period), 0.0018, 0.0018));
    light = std::max(light, 0.5 * band(from_line(x - 0.18 * period, period), 0.0012, 0.0015));
  }
  Vector3d colour = mix(rgb(wear.shirt), rgb(wear.shirt_check), 0.9 * dark);
  colour = mix(colour, rgb(wear.shirt_line), 0.8 * light);
  const double twill = std::sin((uv.x() + uv.y()) * 2.0 * std::numbers::pi / 0.0075);
  return colour * (1.0 + 0.07 * twill + 0.16 * spot.grain(0.006, 11) + 0.10 * spot.grain(0.03, 12));
}

Vector3d shirt_front(const Spot& spot, Vector3d colour) {
  const Vector3d& p = spot.p;
  if (p.x() < 0.0 || p.z() > 1.475) return colour;
  const double placket = band(p.y(), 0.016, 0.002);
  colour *= 1.0 - 0.35 * band(std::abs(p.y()) - 0.017, 0.0012, 0.002);  // its stitched edges
  colour = mix(colour, colour * 1.12, placket);
  const double button = disc(p.y(), from_line(p.z() - 0.03, 0.085), 0.0055, 0.0015);
  colour = mix(colour, Vector3d(0.93, 0.90, 0.82), button);
  colour = mix(colour, Vector3d(0.25, 0.2, 0.18), disc(p.y(), from_line(p.z() - 0.03, 0.085), 0.0012, 0.0015));
  const double px = p.y() - 0.085, pz = p.z() - 1.285;  // the breast pocket
  const double edge = std::max(std::abs(px) - 0.052, std::abs(pz) - 0.060);
  colour *= 1.0 - 0.45 * band(edge, 0.0015, 0.002) - 0.30 * band(pz - 0.040, 0.001, 0.002) * (edge < 0 ? 1 : 0);
  return colour;
}

Vector3d shirt_colour(const BodyShape& shape, const Spot& spot) {
  const ArmPlace arm = arm_place(spot.p);
  const Eigen::Vector2d uv = cloth_coordinates(spot.p, arm);
  Vector3d colour = plaid(spot, uv);
  if (arm.beyond < 0.0) {
    colour = shirt_front(spot, colour);
    colour *= 1.0 - 0.4 * band(spot.p.z() - 0.912, 0.001, 0.002);  // hem
    const double yoke = band(spot.p.z() - 1.40 + 0.25 * std::abs(spot.p.y()), 0.0012, 0.002);
    colour *= 1.0 - 0.4 * yoke * (spot.p.x() < -0.02 ? 1.0 : 0.0);
  } else {
    const double to_cuff = cut_of(shape.build().outfit).top.sleeve - arm.along;
    colour *= 1.0 - 0.4 * band(to_cuff - 0.028, 0.0012, 0.002);
    colour *= 1.0 - 0.35 * band(arm.beyond - 0.004, 0.0010, 0.002);  // where the sleeve is set in
  }
  return colour;
}

Vector3d trousers_colour(const Spot& spot) {
  const Vector3d& p = spot.p;
  const bool leg = !on_trunk(spot);
  const double round = leg ? spot.place.around * 0.065 : std::atan2(p.y(), p.x()) * 0.16;
  const double rib = std::sin(round * 2.0 * std::numbers::pi / 0.0075);
  Vector3d colour =
      rgb(spot.clothing.trousers) * (1.0 + 0.09 * rib + 0.16 * spot.grain(0.008, 21) + 0.12 * spot.grain(0.05, 22));
  const double side_seam = std::abs(spot.place.around) - 0.5 * std::numbers::pi;
  if (leg) {
    colour *= 1.0 - 0.35 * band(side_seam * 0.065, 0.0015, 0.002);
    const double stitch = band(side_seam * 0.065 - 0.007, 0.001, 0.0015) * (from_line(p.z(), 0.008) > 0 ? 1.0 : 0.3);
    colour = mix(colour, Vector3d(0.86, 0.74, 0.5), 0.55 * stitch);
    colour *= 1.0 + 0.12 * band(p.z() - 0.50, 0.03, 0.05) * (p.x() > 0.02 ? 1.0 : 0.0);  // worn knees
    colour *= 1.0 - 0.3 * band(p.z() - 0.118, 0.001, 0.002);                             // turn-up
  }
  const double slant = p.z() - 0.84 + 1.1 * (std::abs(p.y()) - 0.15);  // front pockets
  if (p.x() > 0.02) colour *= 1.0 - 0.4 * band(slant, 0.002, 0.002) * band(p.z() - 0.84, 0.06, 0.01);
  const double bx = std::abs(p.y()) - 0.085, bz = p.z() - 0.845;  // back pockets
  const double edge = std::max(std::abs(bx) - 0.055, std::abs(bz) - 0.05);
  if (p.x() < -0.02) colour *= 1.0 - 0.35 * band(edge, 0.0015, 0.002);
  return colour;
}

Vector3d shoe_colour(const Spot& spot, bool is_laced) {
  const Vector3d& p = spot.p;
  const double leather = 0.35 + 0.65 * (1.0 - rgb(spot.clothing.shoe).mean());  // pale leather is even
  Vector3d colour =
      rgb(spot.clothing.shoe) * (1.0 + leather * (0.16 * spot.grain(0.012, 31) + 0.10 * spot.grain(0.035, 32)));
  const double across = std::abs(p.y()) - 0.195;
  const bool instep =
      is_laced && p.x() > 0.045 && p.x() < 0.125 && p.z() > 0.05 && p.z() < 0.10 && std::abs(across) < 0.03;
  if (instep) {
    const double lace =
        band(from_line(p.x() + 0.4 * std::abs(across), 0.014), 0.0022, 0.0015) * band(across, 0.020, 0.003);
    colour = mix(colour, Vector3d(0.80, 0.74, 0.62), lace);
  }
  colour *= 1.0 - 0.4 * band(p.x() - 0.145 + 2.0 * across * across / 0.04, 0.0015, 0.002);  // toe cap
  const double welt = band(p.z() - 0.028, 0.0015, 0.0015) * (from_line(p.x() + p.y(), 0.009) > 0 ? 1.0 : 0.2);
  return mix(colour, Vector3d(0.85, 0.72, 0.45), 0.7 * welt);
}

// How far a point of the shoe lies within the opening of a court shoe, where the foot shows; metres.
double court_opening(const Vector3d& p) {
  const double edge = p.x() > 0.0 ? 0.052 + 2.2 * std::pow(std::max(0.0, 0.085 - p.x()) - 0.085, 2) : 0.068;
  return p.x() < 0.098 ? p.z() - edge : -1.0;
}

Vector3d sole_colour(const Spot& spot) {
  return rgb(spot.clothing.sole) * (1.0 + 0.2 * spot.grain(0.007, 81));
}

Vector3d bare_colour(const BodyShape& shape, const Spot& spot, const Vector3d& p) {
  switch (spot.place.material) {
    case Material::hair:
      return hair_colour(shape, spot.clothing, p);
    case Material::shoe:
      if (shape.build().outfit == Outfit::dress && court_opening(spot.p) > 0.0) break;
      return shoe_colour(spot, shape.build().outfit != Outfit::dress);
    case Material::sole:
      return sole_colour(spot);
    case Material::skin:
    case Material::shirt:
    case Material::trousers:
      break;
  }
  return skin_colour(shape, spot.clothing, p, spot.place);
}

}  // namespace

Vector3d colour_at(const BodyShape& shape, const Clothing& clothing, const Vector3d& p, const BodyPlace& place) {
  const Spot spot{clothing, p * (1.75 / shape.build().height), place, shape.build().seed};
  const auto clipped = [](const Vector3d& colour) -> Vector3d { return colour.cwiseMax(0.0).cwiseMin(1.0); };
  const Garment garment = place.worn.garment;
  if (garment == Garment::bare) return clipped(bare_colour(shape, spot, p));
  if (garment == Garment::shirt) return clipped(shirt_colour(shape, spot));
  if (garment == Garment::trousers && shape.build().outfit == Outfit::loose_shirt)
    return clipped(trousers_colour(spot));
  return clipped(garment_colour(clothing, spot.p, place, shape.build()));
}

}  // namespace rotunda::simulator
