#include "simulator/people/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "simulator/people/blend.h"
#include "simulator/people/body_trunk.h"
#include "simulator/people/hair.h"
#include "simulator/people/solid_noise.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

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
  const Vector3d q = (part.axes * (p - part.a)).cwiseQuotient(part.radii);
  const double k0 = q.norm(), k1 = q.cwiseQuotient(part.radii).norm();
  return k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -part.radii.minCoeff();
}

// How fast the distance of a part may change along a way.
double steepest(const BodyPart& part) {
  if (part.kind == BodyPart::Kind::cone) return 1.0 / std::min(1.0, part.flatness);
  return part.kind == BodyPart::Kind::ellipsoid ? part.radii.maxCoeff() / part.radii.minCoeff() : 2.0;
}

constexpr double kReferenceHeight = 1.75;
constexpr double kShirtHem = 0.900;  // metres above the floor, of a body of 1.75 m
constexpr double kHemStep = 0.009;   // how far a loose shirt stands off the trousers
constexpr double kGridCell = 0.040;
constexpr double kGridMargin = 0.10;  // farther from the body all parts are asked

Joint trunk_joint(double z) {
  if (z < 1.03) return Joint::pelvis;
  if (z < 1.20) return Joint::spine;
  return z < 1.47 ? Joint::chest : Joint::neck;
}

bool is_cloth(Material material) {
  return material == Material::shirt || material == Material::trousers;
}

}  // namespace

HeadFrame::HeadFrame(const Skeleton& skeleton, const BodyBuild& build)
    : joint(skeleton.joint[index(Joint::head)]),
      reference_joint(0.0, 0.0, 0.890 * 1.75),
      // Head heights of people of 1.55 m and 1.95 m differ by a tenth, not by a quarter (ISO 7250-2).
      scale(std::pow(build.height / 1.75, 0.5) * (build.sex == Sex::male ? 1.0 : 0.985)) {}

class BodyShape::Probe {
 public:
  Probe(const BodyShape& shape, const Vector3d& p) : point(p), shape_(shape) {}
  const Vector3d point;
  double fold() {
    if (!fold_) fold_ = (0.35 + 0.65 * shape_.build_.ease) * shape_.fold(point);
    return *fold_;
  }

 private:
  const BodyShape& shape_;
  std::optional<double> fold_;
};

BodyShape::BodyShape(const Skeleton& skeleton, const BodyBuild& build)
    : build_(build),
      head_(skeleton, build),
      garments_(build.outfit, build.girth, build.seed),
      parts_(body_parts(skeleton, build)),
      all_parts_(parts_.size()) {
  std::iota(all_parts_.begin(), all_parts_.end(), std::uint16_t{0});
  Vector3d low = Vector3d::Constant(1e3), high = -low;
  for (const auto& part : parts_) {
    low = low.cwiseMin((part.centre.array() - part.reach - kGridMargin).matrix());
    high = high.cwiseMax((part.centre.array() + part.reach + kGridMargin).matrix());
  }
  grid_ = PartGrid(low, high, kGridCell,
                   [&](const Vector3d& middle, double radius) { return parts_that_matter(middle, radius); });
}

// A part matters if somewhere in the ball it may come within its blend of the nearest one.
std::vector<std::uint16_t> BodyShape::parts_that_matter(const Vector3d& middle, double radius) const {
  std::vector<std::uint16_t> matter;
  const double body = joined_distance(all_parts_, middle);
  if (body > kGridMargin + radius) return matter;
  Probe probe(*this, middle);
  double nearest = std::numeric_limits<double>::max();
  std::vector<double> least(parts_.size(), std::numeric_limits<double>::max());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const double ball = (middle - parts_[i].centre).norm() - parts_[i].reach - radius;
    if (ball > kGridMargin + 3.0 * radius) continue;
    const double own = part_distance(parts_[i], probe);
    least[i] = std::max(ball, own - steepest(parts_[i]) * radius);
    if (!parts_[i].carve) nearest = std::min(nearest, own + radius);
  }
  nearest = std::max({nearest, body + radius, 0.0});
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (least[i] <= parts_[i].blend + (parts_[i].carve ? 0.0 : nearest))
      matter.push_back(static_cast<std::uint16_t>(i));
  return matter;
}

double BodyShape::trunk_distance(const Vector3d& p) const {
  const double scale = build_.height / 1.75;
  const Vector3d q = p / scale;
  return scale * rotunda::simulator::trunk_distance(build_, q, q.z() > kShirtHem ? kHemStep * build_.ease : 0.0);
}

// Creases of cloth: long across the limb, short along it.
double BodyShape::fold(const Vector3d& p) const {
  const Vector3d stretched(p.x() / 0.09, p.y() / 0.09, p.z() / 0.045);
  return 0.0045 * fractal_noise(stretched, 2, build_.seed);
}

double BodyShape::part_distance(const BodyPart& part, Probe& probe) const {
  const Vector3d& p = probe.point;
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
    case BodyPart::Kind::scalp:
      d = head_.scale * hair_distance(build_, head_.to_reference(p));
      break;
  }
  return is_cloth(part.material) && std::abs(d) < 0.05 ? d + probe.fold() : d;
}

double BodyShape::bare_distance(const Vector3d& p) const {
  const auto near = grid_.parts_at(p);
  return joined_distance(near.empty() ? all_parts_ : near, p);
}

double BodyShape::joined_distance(std::span<const std::uint16_t> parts, const Vector3d& p) const {
  Probe probe(*this, p);
  double d = 1e3;
  for (const auto i : parts) {
    const BodyPart& part = parts_[i];
    const double at_least = (p - part.centre).norm() - part.reach;
    if (at_least > (part.carve ? part.blend : d + part.blend)) continue;
    const double own = part_distance(part, probe);
    d = part.carve ? smooth_max(d, -own, part.blend) : smooth_min(d, own, part.blend);
  }
  return d;
}

double BodyShape::distance(const Vector3d& p) const {
  const double scale = build_.height / kReferenceHeight;
  return scale * garments_.distance(p / scale, bare_distance(p) / scale);
}

double BodyShape::looseness(const Vector3d& p) const {
  return garments_.looseness(p * (kReferenceHeight / build_.height));
}

double BodyShape::reach() const {
  return garments_.reach() * build_.height / kReferenceHeight;
}

Vector3d BodyShape::gradient(const Vector3d& p) const {
  constexpr double step = 0.0015;
  Vector3d g = Vector3d::Zero();
  for (const Vector3d& k : {Vector3d(1, -1, -1), Vector3d(-1, -1, 1), Vector3d(-1, 1, -1), Vector3d(1, 1, 1)})
    g += k * distance(p + step * k);
  return g / (4.0 * step);
}

std::size_t BodyShape::nearest_part(const Vector3d& p) const {
  const auto near = grid_.parts_at(p);
  return nearest_of(near.empty() ? all_parts_ : near, p);
}

std::size_t BodyShape::nearest_of(std::span<const std::uint16_t> parts, const Vector3d& p) const {
  Probe probe(*this, p);
  std::size_t nearest = 0;
  double best = std::numeric_limits<double>::max();
  for (const auto i : parts) {
    const auto& part = parts_[i];
    if (part.carve || (p - part.centre).norm() - part.reach > best) continue;
    const double d = part_distance(part, probe);
    if (d >= best) continue;
    best = d;
    nearest = i;
  }
  return nearest;
}

BodyPlace BodyShape::place_on(std::size_t part_index, const Vector3d& p) const {
  const BodyPart& part = parts_[part_index];
  BodyPlace place{part.material, part.joint};
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
  place.to_end = (part.b - part.a).norm() - place.along;
  place.around = std::atan2(from.dot(side), from.dot(front));
  if (place.material == Material::sole || place.material == Material::hair) return place;
  const GarmentPlace worn = garments_.place_of(p * (kReferenceHeight / build_.height));
  if (place.material != Material::shoe || worn.garment == Garment::trousers) place.worn = worn;  // they hang over it
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
