// Measures are of a man of 1.75 m in shoes; other heights scale. Widths follow the medians of ISO 7250-2.
#include <cmath>

#include "simulator/people/body_shape.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

constexpr double kReferenceHeight = 1.75;

class PartList {
 public:
  PartList(const Skeleton& skeleton, const BodyBuild& build)
      : skeleton_(skeleton), scale_(build.height / kReferenceHeight), girth_(build.girth) {}

  BodyPart& cone(Joint joint, Material material, const Vector3d& a, const Vector3d& b, double ra, double rb,
                 double blend) {
    BodyPart part;
    part.joint = joint;
    part.material = material;
    part.a = a;
    part.b = b;
    part.radius_a = ra * scale_ * girth_;
    part.radius_b = rb * scale_ * girth_;
    part.blend = blend;
    return add(part);
  }
  BodyPart& ellipsoid(Joint joint, Material material, const Vector3d& centre, const Vector3d& radii, double blend) {
    BodyPart part;
    part.kind = BodyPart::Kind::ellipsoid;
    part.joint = joint;
    part.material = material;
    part.a = part.b = centre * scale_;
    part.radii = radii * scale_;
    part.blend = blend;
    return add(part);
  }
  BodyPart& add(const BodyPart& part) { return parts.emplace_back(part); }

  Vector3d joint(Joint left, Side side) const { return skeleton_.joint[index(on_side(left, side))]; }
  double scale() const { return scale_; }

  std::vector<BodyPart> parts;

 private:
  const Skeleton& skeleton_;
  double scale_, girth_;
};

Vector3d at(double x, double y, double z) {
  return {x, y, z};
}

void add_trunk(PartList& body) {
  BodyPart trunk;
  trunk.kind = BodyPart::Kind::trunk;
  trunk.joint = Joint::spine;
  trunk.material = Material::shirt;
  trunk.a = at(0, 0, 0.80) * body.scale();
  trunk.b = at(0, 0, 1.53) * body.scale();
  trunk.radius_a = trunk.radius_b = 0.24 * body.scale();
  body.add(trunk);
  for (const Side side : {Side::left, Side::right}) {
    const double s = sign_of(side);
    body.ellipsoid(Joint::chest, Material::shirt, at(0.050, s * 0.075, 1.305), at(0.055, 0.075, 0.060), 0.05);
    body.cone(Joint::chest, Material::shirt, at(-0.020, s * 0.045, 1.455) * body.scale(),
              at(-0.015, s * 0.165, 1.424) * body.scale(), 0.046, 0.050, 0.05);
    body.ellipsoid(Joint::chest, Material::shirt, at(-0.085, s * 0.085, 1.340), at(0.040, 0.070, 0.090), 0.05);
  }
}

void add_leg(PartList& body, Side side) {
  const double s = sign_of(side), scale = body.scale();
  const auto on = [&](Joint left) { return on_side(left, side); };
  const Vector3d hip = body.joint(Joint::thigh_left, side), knee = body.joint(Joint::shank_left, side);
  const Vector3d ankle = body.joint(Joint::foot_left, side);
  body.ellipsoid(Joint::pelvis, Material::trousers, at(-0.055, s * 0.072, 0.905), at(0.080, 0.082, 0.090), 0.04);
  body.cone(on(Joint::thigh_left), Material::trousers, hip - at(0, 0, 0.02 * scale), knee, 0.090, 0.063, 0.03);
  const Vector3d calf = knee + 0.30 * (ankle - knee) + at(-0.014 * scale, 0, 0);
  body.cone(on(Joint::shank_left), Material::trousers, knee, calf, 0.062, 0.065, 0.02);
  auto& hem =
      body.cone(on(Joint::shank_left), Material::trousers, calf, ankle + at(-0.006, 0, 0) * scale, 0.065, 0.064, 0.02);
  hem.open_end = true;
}

void add_shoe(PartList& body, Side side) {
  const double s = sign_of(side), scale = body.scale();
  const auto on = [&](Joint left) { return on_side(left, side); };
  const Vector3d ankle = body.joint(Joint::foot_left, side), toes = body.joint(Joint::toes_left, side);
  const auto from_ankle = [&](double x, double y, double z) -> Vector3d {
    return at(ankle.x() + x * scale, ankle.y() + s * y * scale, z * scale);
  };
  body.cone(on(Joint::foot_left), Material::shoe, ankle + at(0, 0, 0.05 * scale), from_ankle(-0.012, 0, 0.055), 0.047,
            0.044, 0.006);
  body.cone(on(Joint::foot_left), Material::shoe, from_ankle(-0.028, 0, 0.050), from_ankle(0.07, 0.0, 0.055), 0.037,
            0.040, 0.02);
  body.cone(on(Joint::foot_left), Material::shoe, from_ankle(0.06, 0.0, 0.056), from_ankle(0.135, 0.003, 0.040), 0.040,
            0.036, 0.02);
  auto& toe = body.cone(on(Joint::toes_left), Material::shoe, from_ankle(0.125, 0.004, 0.038),
                        from_ankle(0.182, 0.0, 0.036), 0.038, 0.029, 0.02);
  toe.across = Vector3d::UnitY();
  toe.flatness = 1.22;
  for (const double front : {0.0, 1.0}) {  // the sole, in two pieces that bend at the ball
    auto& sole = body.cone(front > 0 ? on(Joint::toes_left) : on(Joint::foot_left), Material::sole,
                           front > 0 ? Vector3d(toes.x(), toes.y(), 0.012 * scale) : from_ankle(-0.036, 0, 0.012),
                           front > 0 ? from_ankle(0.180, 0, 0.012) : from_ankle(0.125, 0, 0.012),
                           front > 0 ? 0.047 : 0.036, front > 0 ? 0.036 : 0.046, 0.004);
    sole.across = Vector3d::UnitZ();
    sole.flatness = 0.30;
  }
}

void add_hand(PartList& body, Side side) {
  const double scale = body.scale();
  const auto on = [&](Joint left) { return on_side(left, side); };
  const Vector3d wrist = body.joint(Joint::hand_left, side);
  const Vector3d out = (wrist - body.joint(Joint::forearm_left, side)).normalized();
  const Vector3d front = Vector3d::UnitX(), through = out.cross(front);  // across the palm, out of the palm
  const auto from_wrist = [&](double along, double forward, double palm) -> Vector3d {
    return wrist + scale * (along * out + forward * front + palm * through * sign_of(side));
  };
  auto& palm = body.cone(on(Joint::hand_left), Material::skin, from_wrist(0.03, 0, 0), from_wrist(0.075, 0.002, 0),
                         0.037, 0.042, 0.015);
  palm.across = through;
  palm.flatness = 0.40;
  auto& fingers = body.cone(on(Joint::hand_left), Material::skin, from_wrist(0.09, 0, 0), from_wrist(0.155, 0.0, 0.012),
                            0.040, 0.026, 0.008);
  fingers.across = through;
  fingers.flatness = 0.36;
  body.cone(on(Joint::hand_left), Material::skin, from_wrist(0.028, 0.022, 0), from_wrist(0.065, 0.050, 0.008), 0.017,
            0.013, 0.012);
  body.cone(on(Joint::hand_left), Material::skin, from_wrist(0.065, 0.050, 0.008), from_wrist(0.098, 0.057, 0.012),
            0.013, 0.010, 0.006);
}

void add_arm(PartList& body, Side side) {
  const auto on = [&](Joint left) { return on_side(left, side); };
  const Vector3d shoulder = body.joint(Joint::upper_arm_left, side), elbow = body.joint(Joint::forearm_left, side);
  const Vector3d wrist = body.joint(Joint::hand_left, side);
  const Vector3d sleeve_end = elbow + 0.16 * (wrist - elbow), bulge = elbow + 0.28 * (wrist - elbow);
  body.cone(on(Joint::upper_arm_left), Material::shirt, shoulder, elbow, 0.057, 0.051, 0.045);
  body.cone(on(Joint::forearm_left), Material::skin, elbow, bulge, 0.041, 0.044, 0.01);
  auto& lower = body.cone(on(Joint::forearm_left), Material::skin, bulge, wrist, 0.044, 0.029, 0.02);
  lower.across = elbow.cross(wrist).normalized();
  auto& sleeve = body.cone(on(Joint::forearm_left), Material::shirt, elbow, sleeve_end, 0.052, 0.054, 0.01);
  sleeve.open_end = true;
}

void add_face(PartList& body) {
  using enum Material;
  body.cone(Joint::head, skin, at(0.092, 0, 1.648) * body.scale(), at(0.109, 0, 1.610) * body.scale(), 0.009, 0.0125,
            0.012);
  body.ellipsoid(Joint::head, skin, at(0.083, 0, 1.668), at(0.016, 0.050, 0.010), 0.014);
  body.ellipsoid(Joint::head, skin, at(0.092, 0, 1.573), at(0.011, 0.025, 0.011), 0.010);
  body.ellipsoid(Joint::head, skin, at(0.082, 0, 1.540), at(0.018, 0.024, 0.018), 0.020);
  for (const Side side : {Side::left, Side::right}) {
    const double s = sign_of(side);
    body.ellipsoid(Joint::head, skin, at(0.104, s * 0.012, 1.607), at(0.010, 0.008, 0.007), 0.006);
    auto& socket = body.ellipsoid(Joint::head, skin, at(0.102, s * 0.033, 1.650), at(0.018, 0.018, 0.012), 0.012);
    socket.carve = true;
    body.ellipsoid(Joint::head, skin, at(0.0745, s * 0.032, 1.649), at(0.0135, 0.0135, 0.0125), 0.004);
    body.ellipsoid(Joint::head, skin, at(0.068, s * 0.045, 1.615), at(0.020, 0.018, 0.018), 0.020);
    body.ellipsoid(Joint::head, skin, at(-0.004, s * 0.078, 1.632), at(0.018, 0.009, 0.032), 0.006);
  }
}

void add_head(PartList& body, const BodyBuild& build) {
  using enum Material;
  const double k = body.scale();
  body.cone(Joint::neck, skin, at(-0.018, 0, 1.44) * k, at(0.000, 0, 1.58) * k, 0.060, 0.054, 0.02);
  body.ellipsoid(Joint::head, skin, at(-0.006, 0, 1.658), at(0.096, 0.075, 0.088), 0.02);
  body.ellipsoid(Joint::head, skin, at(0.030, 0, 1.598), at(0.062, 0.058, 0.074), 0.03);
  add_face(body);
  const double thick = 0.012 * build.hair_volume;
  body.ellipsoid(Joint::head, Material::hair, at(-0.016, 0, 1.672), at(0.091 + thick, 0.073 + thick, 0.074 + thick),
                 0.006);
  body.ellipsoid(Joint::head, Material::hair, at(-0.040, 0, 1.625), at(0.060 + thick, 0.064 + thick, 0.065), 0.012);
  auto& collar = body.cone(Joint::neck, shirt, at(-0.022, 0, 1.43) * k, at(-0.006, 0, 1.505) * k, 0.084, 0.068, 0.006);
  collar.open_end = true;
}

void bound(BodyPart& part) {
  part.centre = 0.5 * (part.a + part.b);
  const double thick = part.kind == BodyPart::Kind::ellipsoid
                           ? part.radii.maxCoeff()
                           : std::max(part.radius_a, part.radius_b) * std::max(1.0, part.flatness);
  part.reach = 0.5 * (part.b - part.a).norm() + thick + 0.01;
}

}  // namespace

std::vector<BodyPart> body_parts(const Skeleton& skeleton, const BodyBuild& build) {
  PartList body(skeleton, build);
  add_trunk(body);
  for (const Side side : {Side::left, Side::right}) add_leg(body, side);
  for (const Side side : {Side::left, Side::right}) add_arm(body, side);
  add_head(body, build);
  for (const Side side : {Side::left, Side::right}) {
    add_hand(body, side);
    add_shoe(body, side);
  }
  for (auto& part : body.parts) bound(part);
  return body.parts;
}

}  // namespace rotunda::simulator
