#include "simulator/people/skin_colour.h"

#include <numbers>

#include "simulator/people/hair.h"
#include "simulator/people/paint.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using namespace paint;
using Eigen::Vector3d;

// Moles and freckles: one at a random place in some cells of a lattice.
double spots(const Vector3d& q, double cell_size, double radius, double share, std::uint32_t seed) {
  const Vector3d cell = (q / cell_size).array().floor();
  const auto random = [&](std::uint32_t axis) {
    return hashed_unit(static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
                       static_cast<std::int64_t>(cell.z()), seed + axis);
  };
  if (random(3) > share) return 0.0;
  const Vector3d centre = cell + Vector3d::Constant(0.3) + 0.4 * Vector3d(random(0), random(1), random(2));
  return band((q - centre * cell_size).norm(), radius, radius);
}

bool is_finger(Joint joint) {
  const auto within = [&](Joint first, Joint last) { return joint >= first && joint <= last; };
  return within(Joint::thumb1_left, Joint::little2_left) || within(Joint::thumb1_right, Joint::little2_right);
}

bool is_left(Joint joint) {
  return joint < Joint::clavicle_right;
}

// Redder towards the tips, creased over the joints; nails on the back.
Vector3d finger_colour(const BodyPlace& place, double scale, Vector3d colour) {
  const bool last = (index(place.joint) - index(Joint::thumb1_left)) % 2 == (is_left(place.joint) ? 1U : 0U);
  const double along = place.along / scale, left = place.to_end / scale;
  if (last)
    for (const double crease : {0.000, 0.0024})
      colour = mix(colour, colour * 0.90, band(along - crease, 0.0003, 0.0012));
  colour = colour.cwiseProduct(last ? Vector3d(1.0, 0.90, 0.87) : Vector3d(1.0, 0.95, 0.93));
  if (!last) return colour;
  const double back = (is_left(place.joint) ? -0.5 : 0.5) * std::numbers::pi;
  const double off = std::remainder(place.around - back, 2.0 * std::numbers::pi) * 0.0075;
  const double nail = std::max(std::abs(off) - 0.0052, std::abs(left - 0.0015) - 0.0062);
  colour = mix(colour, colour * 0.70, band(nail, 0.0003, 0.0007));
  return mix(colour, mix(colour, Vector3d(0.94, 0.80, 0.76), 0.55), step_up(-nail, 0.0006));
}

Vector3d hand_colour(const BodyPlace& place, const Vector3d& colour) {
  return colour.cwiseProduct(mix(Vector3d::Ones(), Vector3d(1.0, 0.93, 0.91), step_up(place.along - 0.02, 0.05)));
}

// The shadow within the bowl of the ear and under its rim.
double ear_hollow(const Vector3d& q) {
  const double bowl = disc(q.x() + 0.008, q.z() - 1.6255, 0.006, 0.006);
  const double rim = band(std::hypot(q.x() + 0.0165, 0.85 * (q.z() - 1.6410)) - 0.0105, 0.0008, 0.0022);
  return std::max(bowl, 0.6 * rim * step_up(q.z() - 1.630, 0.01));
}

}  // namespace

Vector3d skin_colour(const BodyShape& shape, const Clothing& look, const Vector3d& p, const BodyPlace& place) {
  const BodyBuild& build = shape.build();
  const Vector3d q = p * (1.75 / build.height);
  Vector3d colour = rgb(look.skin);
  colour = colour.cwiseProduct(Vector3d(1.0, 0.97, 0.96) +
                               Vector3d(0.04, 0.07, 0.08) * fractal_noise(q / 0.035, 3, build.seed + 51));
  colour *= 1.0 + 0.035 * solid_noise(q / 0.0022, build.seed + 55) + 0.03 * solid_noise(q / 0.006, build.seed + 56);
  colour = mix(colour, colour.cwiseProduct(Vector3d(0.62, 0.48, 0.42)), spots(q, 0.055, 0.0011, 0.22, build.seed + 60));
  const double freckle = spots(q, 0.0065, 0.0008, look.freckles, build.seed + 70);
  colour = mix(colour, colour.cwiseProduct(Vector3d(0.80, 0.66, 0.56)), 0.7 * freckle);
  const Joint j = place.joint;
  if (is_finger(j)) return finger_colour(place, build.height / 1.75, colour);
  if (j == Joint::hand_left || j == Joint::hand_right) return hand_colour(place, colour);
  if (j != Joint::head) return colour;
  const Vector3d head = shape.head().to_reference(p);
  const double ear = step_up(std::abs(head.y()) - 0.0785, 0.004) * band(head.z() - 1.628, 0.030, 0.008) *
                     step_up(0.008 - head.x(), 0.008);
  colour = mix(colour, colour.cwiseProduct(Vector3d(0.98, 0.86, 0.83)), ear);
  if (head.x() > 0.010) colour = face_colour(build, look, head, colour);
  const double roots = hair_cover(build, head) * (0.8 + 0.5 * solid_noise(head / 0.0020, build.seed + 57));
  colour *= 1.0 - 0.35 * ear * ear_hollow(head);
  return mix(colour, rgb(look.hair) * 0.85, (1.0 - ear) * roots);
}

namespace {

// How much hair hides the scalp, 0 to 1: single strands in front, all of it where a bob falls over the skin and behind.
double strand_cover(const BodyBuild& build, const Vector3d& q) {
  if (q.x() < -0.05 || q.z() < 1.560 || build.hair == HairStyle::bald) return 1.0;
  const double falling = build.hair == HairStyle::bob ? step_up(std::max(1.668 - q.z(), 0.030 - q.x()), 0.014) : 0.0;
  return std::max(hair_cover(build, q), falling);
}

}  // namespace

SurfaceMaterial skin_material(const BodyShape& shape, const Vector3d& p, const BodyPlace& place) {
  const Vector3d head = shape.head().to_reference(p);
  if (place.material == Material::hair)
    return strand_cover(shape.build(), head) > 0.5 ? SurfaceMaterial::hair : SurfaceMaterial::skin;
  if (place.joint != Joint::head) return SurfaceMaterial::skin;
  if (hair_cover(shape.build(), head) > 0.5) return SurfaceMaterial::hair;
  if (is_eyeball(shape.build(), head)) return SurfaceMaterial::eye;
  const bool lips = head.x() > 0.075 && std::abs(head.y()) < 0.022 && std::abs(head.z() - 1.5655) < 0.0085;
  return lips ? SurfaceMaterial::lip : SurfaceMaterial::skin;
}

// Strands run back from the forehead over the crown and down the sides.
Vector3d hair_colour(const BodyShape& shape, const Clothing& look, const Vector3d& p) {
  const BodyBuild& build = shape.build();
  const Vector3d q = shape.head().to_reference(p);
  const double round = std::atan2(q.y(), q.x() + 0.03), top = step_up(q.z() - 1.705, 0.05);
  const Vector3d falls(round * 0.085 / 0.0016, q.z() / 0.035, q.x() / 0.05);
  const Vector3d combed(q.y() / 0.0016, q.x() / 0.030, q.z() / 0.03);
  const auto strands = [&](const Vector3d& at, std::uint32_t channel) {
    return 0.55 * solid_noise(at, build.seed + channel) + 0.45 * solid_noise(at * 0.31, build.seed + channel + 1);
  };
  double strand = (1.0 - top) * strands(falls, 71) + top * strands(combed, 73);
  const double sheen = band(q.z() - 1.712 + 0.02 * strand, 0.004, 0.022);
  if (q.x() < -0.115) strand = strands(Vector3d(q.y() / 0.0016, q.z() / 0.060, q.x() / 0.0050), 77);  // a tail hangs
  Vector3d colour = rgb(look.hair) * (1.0 + 0.75 * strand + 0.20 * solid_noise(q / 0.03, build.seed + 75));
  colour = mix(colour, colour * 1.45 + Vector3d::Constant(0.02), 0.45 * sheen);
  colour = colour.cwiseMax(0.35 * rgb(look.hair));
  const double cover = strand_cover(build, q);
  return cover < 1.0 ? mix(skin_colour(shape, look, p, {Material::skin, Joint::head}), colour, cover) : colour;
}

}  // namespace rotunda::simulator
