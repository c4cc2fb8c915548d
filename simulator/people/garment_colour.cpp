#include "simulator/people/garment_colour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulator/people/garment_cut.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kTurn = 2.0 * std::numbers::pi;

Vector3d rgb(const recon::Colour& colour) {
  return Vector3d(colour[0], colour[1], colour[2]) / 255.0;
}
Vector3d mix(const Vector3d& a, const Vector3d& b, double t) {
  return a + (b - a) * std::clamp(t, 0.0, 1.0);
}
// 1 within `half` of zero, falling to 0 over 2 mm.
double line(double x, double half) {
  return std::clamp((half + 0.002 - std::abs(x)) / 0.002, 0.0, 1.0);
}
double from_multiple(double x, double period) {
  return x - period * std::round(x / period);
}
double stitched(double across, double along) {
  return line(across, 0.0008) * (from_multiple(along, 0.0075) > -0.0012 ? 1.0 : 0.0);
}
double spot(double x, double y, double radius) {
  return line(std::hypot(x, y), radius);
}

struct Swatch {
  const Clothing& wear;
  const Cut& cut;
  const BodyBuild& build;
  Vector3d q;
  Garment garment;
  ArmPlace arm;
  Vector2d uv;  // metres along the warp (down or along the sleeve) and round the body
  double grain(double size, std::uint32_t channel) const { return solid_noise(q / size, build.seed + channel); }
  double random(const Vector2d& cell, std::uint32_t channel) const {
    return hashed_unit(static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()), 0,
                       build.seed + channel);
  }
};

// Wales of a fine knit, 3 mm apart, and their stitches.
Vector3d jersey(const Swatch& s, const Vector3d& yarn) {
  const double wale = std::sin(kTurn * s.uv.y() / 0.0062), course = std::sin(kTurn * s.uv.x() / 0.0064 + 1.5 * wale);
  return yarn * (1.0 + 0.05 * wale + 0.05 * course + 0.08 * s.grain(0.005, 111) + 0.06 * s.grain(0.04, 112));
}

Vector3d tee_colour(const Swatch& s) {
  const bool sleeve = s.arm.beyond > 0.0;
  const double to_cuff = s.cut.top.sleeve - s.arm.along;
  const double stripe = line(from_multiple(s.uv.x() + 0.004, 0.034), 0.0062);
  Vector3d colour = jersey(s, mix(rgb(s.wear.shirt), rgb(s.wear.shirt_check), stripe));
  const double neck = -neckline(s.cut.top, s.q);
  if (!sleeve && neck < 0.020) {
    const double rib = std::sin(kTurn * s.uv.y() / 0.0050);
    colour = rgb(s.wear.shirt_check) * (1.0 + 0.15 * rib + 0.08 * s.grain(0.005, 113));
  }
  if (sleeve)
    colour *= 1.0 - 0.35 * stitched(to_cuff - 0.020, s.uv.y()) - 0.35 * stitched(to_cuff - 0.025, s.uv.y());
  else
    colour *=
        1.0 - 0.35 * stitched(neck - 0.022, s.uv.y()) - 0.35 * stitched(s.q.z() - s.cut.top.hem - 0.020, s.uv.y());
  colour *= 1.0 - 0.30 * line(s.arm.beyond - 0.004, 0.001);  // the seam of the sleeve
  const double disc = std::hypot(s.q.y(), s.q.z() - 1.285);  // the print on the chest
  if (s.q.x() > 0.0 && disc < 0.062) {
    const double ring = line(disc - 0.055, 0.003), angle = std::atan2(s.q.z() - 1.285, s.q.y());
    const double star = line(disc - 0.030 * (1.0 + 0.35 * std::cos(5.0 * angle - 0.5 * std::numbers::pi)), 0.0045);
    colour = mix(colour, rgb(s.wear.shirt_line) * (1.0 + 0.1 * s.grain(0.006, 114)), std::max(ring, star));
  }
  return colour;
}

// Indigo warp over white weft: a twill; worn pale over thighs, seat and knees.
Vector3d denim(const Swatch& s, const BodyPlace& place) {
  const Vector3d& q = s.q;
  const bool leg = q.z() < 0.80;
  const double round = leg ? place.around * 0.072 : s.uv.y();
  const double twill = std::sin(kTurn * (q.z() + round) / 0.0068);
  const double slub = solid_noise(Vector3d(q.x() / 0.004, q.y() / 0.004, q.z() / 0.030), s.build.seed + 121);
  const double worn_thigh = std::exp(-std::pow((q.z() - 0.70) / 0.13, 2)) * std::exp(-std::pow(place.around / 0.75, 2));
  const double worn_knee = std::exp(-std::pow((q.z() - 0.50) / 0.06, 2)) * (q.x() > 0.02 ? 1.0 : 0.25);
  const double whisker =
      solid_noise(Vector3d((q.z() + 0.3 * std::abs(q.y())) / 0.012, q.y() / 0.12, 0.5), s.build.seed + 122);
  const double near_crotch = std::exp(-std::pow((q.z() - 0.86) / 0.05, 2)) * (q.x() > 0.0 ? 1.0 : 0.0);
  const double pale = std::clamp(
      0.34 * worn_thigh + 0.24 * worn_knee + 0.16 * std::max(0.0, whisker) * near_crotch + 0.10 * s.grain(0.05, 123),
      0.0, 0.6);
  Vector3d colour = mix(rgb(s.wear.trousers), Vector3d(0.66, 0.68, 0.71), pale);
  colour *= 1.0 + 0.13 * twill + 0.16 * slub;
  const Vector3d thread(0.78, 0.52, 0.24);
  const double side = (std::abs(place.around) - 0.5 * std::numbers::pi) * 0.075;
  if (leg) {
    colour *= 1.0 - 0.35 * line(side, 0.0012);
    colour = mix(colour, thread, 0.75 * std::max(stitched(side - 0.004, q.z()), stitched(side - 0.011, q.z())));
    colour = mix(colour, thread, 0.75 * stitched(q.z() - 0.108, place.around * 0.07));
    colour *= 1.0 + 0.35 * line(q.z() - 0.092, 0.002);
  }
  if (q.x() > 0.02 && q.z() > 0.78) {
    const double pocket = q.z() - 0.90 + 0.9 * std::pow(std::max(0.0, 0.17 - std::abs(q.y())), 2) / 0.05 - 0.0;
    const double span = line(std::abs(q.y()) - 0.115, 0.055);
    colour =
        mix(colour, thread, 0.8 * span * std::max(stitched(pocket + 0.030, q.y()), stitched(pocket + 0.037, q.y())));
    colour *= 1.0 - 0.35 * span * line(pocket + 0.024, 0.0015);
    const double fly = q.y() - 0.022 + 0.25 * std::pow(std::max(0.0, 0.85 - q.z()), 1.0);
    colour = mix(colour, thread, 0.8 * stitched(fly, q.z()) * (q.z() > 0.82 && fly < 0.01 ? 1.0 : 0.0));
    colour *= 1.0 - 0.4 * line(q.y(), 0.001);
  }
  if (q.x() < -0.02 && q.z() > 0.74) {
    const double px = std::abs(q.y()) - 0.078, pz = q.z() - 0.845;
    const double edge = std::max(std::abs(px) - 0.058, std::max(pz - 0.060, -pz - 0.070 + 0.35 * std::abs(px)));
    colour *= 1.0 - 0.35 * line(edge, 0.001);
    colour = mix(colour, thread, 0.8 * std::max(stitched(edge + 0.004, px + pz), stitched(edge + 0.011, px + pz)));
    const double gull = pz - 0.012 - 0.30 * std::abs(std::abs(px) - 0.028);
    colour = mix(colour, thread, edge < -0.012 ? 0.7 * stitched(gull, px) : 0.0);
    colour *= 1.0 - 0.4 * line(q.y(), 0.001);
  }
  return colour;
}

Vector3d chinos(const Swatch& s, const BodyPlace& place) {
  const double round = s.q.z() < 0.80 ? place.around * 0.070 : s.uv.y();
  const double twill = std::sin(kTurn * (s.q.z() - round) / 0.0046);
  Vector3d colour =
      rgb(s.wear.trousers) * (1.0 + 0.08 * twill + 0.14 * s.grain(0.006, 131) + 0.10 * s.grain(0.05, 132));
  const double side = (std::abs(place.around) - 0.5 * std::numbers::pi) * 0.075;
  if (s.q.z() < 0.80) {
    colour *= 1.0 - 0.35 * line(side, 0.001);
    colour *= 1.0 + 0.16 * line(place.around * 0.07, 0.0015);  // the pressed crease
    colour *= 1.0 - 0.30 * stitched(s.q.z() - 0.125, round);
  }
  return colour;
}

// Flowers of five petals in jittered cells, leaves and dots between them.
Vector3d floral(const Swatch& s) {
  constexpr double kCell = 0.046;
  Vector3d colour = rgb(s.wear.shirt) * (1.0 + 0.10 * s.grain(0.005, 141) + 0.07 * s.grain(0.03, 142));
  const Vector2d base = (s.uv / kCell).array().floor();
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j) {
      const Vector2d cell = base + Vector2d(i, j);
      const Vector2d d = s.uv - kCell * (cell + Vector2d(0.2 + 0.6 * s.random(cell, 1), 0.2 + 0.6 * s.random(cell, 2)));
      const double size = 0.009 + 0.008 * s.random(cell, 3),
                   angle = std::atan2(d.y(), d.x()) + kTurn * s.random(cell, 4);
      const double petal = size * (0.72 + 0.34 * std::cos(5.0 * angle)), radius = d.norm();
      const Vector3d bloom = s.random(cell, 5) < 0.6 ? rgb(s.wear.shirt_check) : rgb(s.wear.shirt_line);
      const double leaf = std::hypot(d.x() * std::cos(angle) * 0.6, radius * std::sin(0.5 * angle));
      if (s.random(cell, 6) < 0.8) {
        colour = mix(colour, Vector3d(0.36, 0.48, 0.25),
                     0.8 * line(leaf - 1.35 * size, 0.0011) * (radius < 2.0 * size ? 1.0 : 0.0));
        colour = mix(colour, bloom * (0.80 + 0.2 * std::min(1.0, radius / size)),
                     line(std::max(0.0, radius - petal), 0.0004));
        colour = mix(colour, Vector3d(0.93, 0.78, 0.30), spot(d.x(), d.y(), 0.0022));
      } else {
        colour = mix(colour, rgb(s.wear.shirt_line), spot(d.x(), d.y(), 0.0022));
      }
    }
  const double crepe = std::sin(kTurn * s.uv.x() / 0.0044) * std::sin(kTurn * s.uv.y() / 0.0044);
  return colour * (1.0 + 0.05 * crepe);
}

Vector3d dress_colour(const Swatch& s) {
  Vector3d colour = floral(s);
  const double belt = s.q.z() - 1.072;
  if (std::abs(belt) < 0.021 && s.arm.beyond < 0.0) {
    const double rib = std::sin(kTurn * s.q.z() / 0.0048);
    colour = rgb(s.wear.belt) * (1.0 + 0.10 * rib + 0.10 * s.grain(0.005, 143));
    colour *= 1.0 - 0.4 * line(std::abs(belt) - 0.017, 0.0008);
    return mix(colour, Vector3d(0.82, 0.68, 0.36),
               s.q.x() > 0.0 ? line(std::max(std::abs(s.q.y()) - 0.016, std::abs(belt) - 0.013), 0.0022) -
                                   line(std::max(std::abs(s.q.y()) - 0.012, std::abs(belt) - 0.009), 0.0)
                             : 0.0);
  }
  if (s.garment == Garment::bodice) {
    colour *= 1.0 - 0.35 * line(std::abs(s.q.y()) - 0.085 - 0.10 * std::pow(s.q.z() - 1.22, 2) / 0.02, 0.0009);
    const double neck = -neckline(s.cut.top, s.q);
    colour *= 1.0 - 0.30 * stitched(s.arm.along - s.cut.top.sleeve + 0.012, s.q.x() + s.q.z());
    if (s.q.x() < 0.0) colour *= 1.0 - 0.45 * line(s.q.y(), 0.001) - 0.3 * stitched(neck - 0.012, s.q.y());
  } else {
    colour *= 1.0 - 0.35 * stitched(s.q.z() - s.cut.bell->hem - 0.024, s.uv.y());
    colour *= 1.0 - 0.30 * line(std::abs(std::atan2(s.q.y(), s.q.x())) * 0.2 - 0.1 * std::numbers::pi, 0.001);
  }
  return colour;
}

// Chevrons 20 mm wide of a twill 5 mm apart, the yarn mixed of light and dark wool.
Vector3d herringbone(const Swatch& s) {
  const double zigzag = std::abs(from_multiple(s.uv.y(), 0.028));
  const double rib = std::sin(kTurn * (s.uv.x() + zigzag) / 0.0062);
  const double melange = 0.14 * s.grain(0.0035, 151) + 0.08 * s.grain(0.011, 152) + 0.05 * s.grain(0.06, 153);
  return mix(rgb(s.wear.shirt), rgb(s.wear.shirt_check), 0.5 + 0.38 * rib) * (1.0 + melange);
}

Vector3d coat_front(const Swatch& s, Vector3d colour) {
  const Vector3d& q = s.q;
  const Vector3d dark = 0.45 * rgb(s.wear.shirt_check), horn(0.16, 0.13, 0.12);
  if (q.z() < 1.30) {
    colour *= 1.0 - 0.50 * line(q.y() + 0.038, 0.0014);  // the edge that lies over
    colour *= 1.0 - 0.22 * stitched(q.y() + 0.030, q.z());
    for (const double z : {1.24, 1.12, 1.00, 0.88}) {
      colour = mix(colour, horn * (1.0 + 0.3 * s.grain(0.006, 154)), spot(q.y() + 0.004, q.z() - z, 0.0115));
      colour = mix(colour, dark,
                   std::max(spot(std::abs(q.y() + 0.004) - 0.0025, q.z() - z, 0.0006),
                            line(std::hypot(q.y() + 0.004, q.z() - z) - 0.0125, 0.0004)));
    }
  }
  const double lapel = std::abs(q.y()) - 0.115 * ramp(q.z(), 1.27, 1.41);
  if (q.z() > 1.265 && q.z() < 1.46) {
    colour *= 1.0 - 0.55 * line(lapel, 0.0013);
    colour *= 1.0 - 0.25 * stitched(lapel + 0.007, q.z());
    colour *= 1.0 - 0.5 * line(q.z() - 1.415 + 0.5 * (std::abs(q.y()) - 0.09), 0.0012) * (lapel < 0.0 ? 1.0 : 0.0);
  }
  const double px = std::abs(q.y()) - 0.125, pz = q.z() - 0.925;
  const double flap = std::max(std::abs(px) - 0.068, std::abs(pz) - 0.026);
  colour *= 1.0 - 0.55 * line(flap, 0.0013) - 0.22 * stitched(flap + 0.006, px + pz);
  return colour;
}

Vector3d coat_colour(const Swatch& s) {
  const Vector3d& q = s.q;
  Vector3d colour = herringbone(s);
  colour *= 1.0 - 0.40 * line(s.arm.beyond - 0.004, 0.0011);
  if (s.arm.beyond > 0.0) {
    const double to_cuff = s.cut.top.sleeve - s.arm.along;
    colour *= 1.0 - 0.30 * line(to_cuff - 0.062, 0.0012);
    for (const double at : {0.018, 0.036})
      colour = mix(colour, Vector3d(0.16, 0.13, 0.12), spot(to_cuff - at, s.uv.y() - 0.10, 0.0055));
    return colour;
  }
  if (q.z() > 1.448 && round_neck(s.cut.top, q) > -0.035)
    return 0.55 * rgb(s.wear.shirt_check) * (1.0 + 0.2 * s.grain(0.004, 155));  // the velvet collar
  if (q.x() > 0.0) return coat_front(s, colour);
  colour *= 1.0 - 0.40 * line(q.y(), 0.0012);
  const double belt = std::abs(q.z() - 1.06) - 0.026;
  colour *= 1.0 - 0.45 * line(belt, 0.0012) * (std::abs(q.y()) < 0.12 ? 1.0 : 0.0);
  return mix(colour, Vector3d(0.16, 0.13, 0.12), spot(std::abs(q.y()) - 0.105, q.z() - 1.06, 0.0105));
}

}  // namespace

Vector3d garment_colour(const Clothing& clothing, const Vector3d& q, const BodyPlace& place, const BodyBuild& build) {
  const ArmPlace arm = arm_place(q);
  const bool hangs = place.worn.garment == Garment::skirt;
  const Vector2d uv = hangs ? Vector2d(-q.z(), 0.20 * std::atan2(q.y(), q.x() + 0.01)) : cloth_coordinates(q, arm);
  const Swatch s{clothing, cut_of(build.outfit), build, q, place.worn.garment, arm, uv};
  switch (s.garment) {
    case Garment::tee:
      return tee_colour(s);
    case Garment::trousers:
      return build.outfit == Outfit::close_fit ? denim(s, place) : chinos(s, place);
    case Garment::bodice:
    case Garment::skirt:
      return dress_colour(s);
    case Garment::coat:
      return coat_colour(s);
    case Garment::undershirt:
      return jersey(s, Vector3d(0.80, 0.79, 0.76));
    case Garment::lining:
      return 0.5 * rgb(clothing.shirt) * (1.0 + 0.12 * s.grain(0.006, 161));
    case Garment::shirt:
    case Garment::bare:
      break;
  }
  return rgb(clothing.shirt);
}

}  // namespace rotunda::simulator
