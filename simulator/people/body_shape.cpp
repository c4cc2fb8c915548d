#include "simulator/people/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

double smooth_min(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width * 0.25;
}
double smooth_max(double a, double b, double width) {
  return -smooth_min(-a, -b, width);
}

struct AxisPlace {
  double t;  // along a-b, not clamped
  Vector3d from_axis;
};

AxisPlace place_on_axis(const BodyPart& part, const Vector3d& p) {
  const Vector3d axis = part.b - part.a;
  const double t = (p - part.a).dot(axis) / axis.squaredNorm();
  return {t, p - part.a - std::clamp(t, 0.0, 1.0) * axis};
}

double cone_distance(const BodyPart& part, const Vector3d& p) {
  auto [t, from_axis] = place_on_axis(part, p);
  if (part.flatness != 1.0) from_axis += part.across * (part.across.dot(from_axis) * (1.0 / part.flatness - 1.0));
  const double radius = part.radius_a + (part.radius_b - part.radius_a) * std::clamp(t, 0.0, 1.0);
  const double side = from_axis.norm() - radius;
  return part.open_end ? std::max(side, (t - 1.0) * (part.b - part.a).norm()) : side;
}

double ellipsoid_distance(const BodyPart& part, const Vector3d& p) {
  const Vector3d q = (p - part.a).cwiseQuotient(part.radii);
  const double k0 = q.norm(), k1 = q.cwiseQuotient(part.radii).norm();
  return k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -part.radii.minCoeff();
}

// Cross-sections of the trunk, from the crotch to the neck, of a body of 1.75 m: height, middle, half depth, half
// width.
struct Section {
  double z, middle, depth, width;
};
constexpr std::array<Section, 11> kTrunk = {{{0.84, -0.012, 0.105, 0.140},
                                             {0.89, -0.012, 0.122, 0.176},
                                             {0.95, -0.008, 0.120, 0.178},
                                             {1.02, -0.006, 0.112, 0.164},
                                             {1.10, -0.008, 0.108, 0.154},
                                             {1.20, -0.012, 0.113, 0.160},
                                             {1.30, -0.016, 0.121, 0.176},
                                             {1.38, -0.020, 0.112, 0.180},
                                             {1.43, -0.022, 0.090, 0.150},
                                             {1.47, -0.022, 0.072, 0.105},
                                             {1.52, -0.018, 0.060, 0.070}}};

double catmull_rom(double p0, double p1, double p2, double p3, double t) {
  return p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

Section section_at(double z) {
  const double inside = std::clamp(z, kTrunk.front().z, kTrunk.back().z - 1e-9);
  std::size_t i = 0;
  while (kTrunk[i + 1].z <= inside) ++i;
  const Section &a = kTrunk[i > 0 ? i - 1 : 0], &b = kTrunk[i], &c = kTrunk[i + 1];
  const Section& d = kTrunk[std::min(i + 2, kTrunk.size() - 1)];
  const double t = (inside - b.z) / (c.z - b.z);
  return {z, catmull_rom(a.middle, b.middle, c.middle, d.middle, t), catmull_rom(a.depth, b.depth, c.depth, d.depth, t),
          catmull_rom(a.width, b.width, c.width, d.width, t)};
}

constexpr double kShirtHem = 0.900;  // metres above the floor, of a body of 1.75 m
constexpr double kHemStep = 0.009;   // how far the shirt stands off the trousers

Joint trunk_joint(double z) {
  if (z < 1.03) return Joint::pelvis;
  if (z < 1.20) return Joint::spine;
  return z < 1.47 ? Joint::chest : Joint::neck;
}

bool is_cloth(Material material) {
  return material == Material::shirt || material == Material::trousers;
}

}  // namespace

BodyShape::BodyShape(const Skeleton& skeleton, const BodyBuild& build)
    : build_(build), parts_(body_parts(skeleton, build)) {}

double BodyShape::trunk_distance(const Vector3d& p) const {
  const double scale = build_.height / 1.75;
  const Vector3d q = p / scale;
  const Section s = section_at(q.z());
  const double hang = q.z() > kShirtHem ? kHemStep : 0.0;
  const Eigen::Vector2d r(s.depth * build_.girth + hang, s.width * build_.girth + hang);
  const Eigen::Vector2d unit = Eigen::Vector2d(q.x() - s.middle, q.y()).cwiseQuotient(r);
  const double k0 = unit.norm(), k1 = unit.cwiseQuotient(r).norm();
  const double side = k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -r.minCoeff();
  return scale * smooth_max(smooth_max(side, q.z() - 1.50, 0.05), 0.845 - q.z(), 0.04);
}

// Creases of cloth: long across the limb, short along it.
double BodyShape::fold(const Vector3d& p) const {
  const Vector3d stretched(p.x() / 0.09, p.y() / 0.09, p.z() / 0.045);
  return 0.0045 * fractal_noise(stretched, 2, build_.seed);
}

double BodyShape::part_distance(const BodyPart& part, const Vector3d& p) const {
  double d = 0.0;
  switch (part.kind) {
    case BodyPart::Kind::cone:
      d = cone_distance(part, p);
      break;
    case BodyPart::Kind::ellipsoid:
      d = ellipsoid_distance(part, p);
      break;
    case BodyPart::Kind::trunk:
      d = trunk_distance(p);
      break;
  }
  return is_cloth(part.material) && std::abs(d) < 0.05 ? d + fold(p) : d;
}

double BodyShape::distance(const Vector3d& p) const {
  double d = 1e3;
  for (const auto& part : parts_) {
    const double at_least = (p - part.centre).norm() - part.reach;
    if (at_least > (part.carve ? part.blend : d + part.blend)) continue;
    const double own = part_distance(part, p);
    d = part.carve ? smooth_max(d, -own, part.blend) : smooth_min(d, own, part.blend);
  }
  return d;
}

Vector3d BodyShape::gradient(const Vector3d& p) const {
  constexpr double step = 0.0015;
  Vector3d g = Vector3d::Zero();
  for (const Vector3d& k : {Vector3d(1, -1, -1), Vector3d(-1, -1, 1), Vector3d(-1, 1, -1), Vector3d(1, 1, 1)})
    g += k * distance(p + step * k);
  return g / (4.0 * step);
}

std::size_t BodyShape::nearest_part(const Vector3d& p) const {
  std::size_t nearest = 0;
  double best = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& part = parts_[i];
    if (part.carve || (p - part.centre).norm() - part.reach > best) continue;
    const double d = part_distance(part, p);
    if (d >= best) continue;
    best = d;
    nearest = i;
  }
  return nearest;
}

BodyPlace BodyShape::place_on(std::size_t part_index, const Vector3d& p) const {
  const BodyPart& part = parts_[part_index];
  BodyPlace place{part.material, part.joint, 0.0, 0.0};
  const double z = p.z() * 1.75 / build_.height;
  if (part.kind == BodyPart::Kind::trunk) place.joint = trunk_joint(z);
  if (part.material == Material::shirt && place.joint == Joint::pelvis && z < kShirtHem)
    place.material = Material::trousers;
  if (part.material == Material::trousers && z >= kShirtHem) place.material = Material::shirt;  // it hangs over them
  const bool axial = part.kind == BodyPart::Kind::cone;
  const Vector3d axis = axial ? Vector3d((part.b - part.a).normalized()) : Vector3d(-Vector3d::UnitZ());
  const Vector3d side = axis.cross(Vector3d::UnitX()).normalized(), front = side.cross(axis);
  const Vector3d from = p - part.a;
  place.along = axial ? from.dot(axis) : -p.z();
  place.around = std::atan2(from.dot(side), from.dot(front));
  return place;
}

double BodyShape::openness(const Vector3d& p, const Vector3d& normal) const {
  double closed = 0.0, weight = 0.35;
  for (const double step : {0.015, 0.04, 0.10, 0.22}) {
    closed += weight * std::clamp((step - distance(p + step * normal)) / step, 0.0, 1.0);
    weight *= 0.75;
  }
  return std::clamp(1.0 - closed, 0.05, 1.0);
}

}  // namespace rotunda::simulator
