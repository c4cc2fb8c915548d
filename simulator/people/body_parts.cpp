// Widths follow the medians of ISO 7250-2.
#include <algorithm>
#include <cmath>

#include "simulator/people/body_part_list.h"

namespace rotunda::simulator {

using Eigen::Vector3d;

BodyPart& PartList::cone(Joint joint, Material material, const Vector3d& a, const Vector3d& b, double ra, double rb,
                         double blend) {
  BodyPart part;
  part.joint = joint;
  part.material = material;
  part.a = a;
  part.b = b;
  part.radius_a = ra * scale_ * build_.girth;
  part.radius_b = rb * scale_ * build_.girth;
  part.blend = blend;
  return add(part);
}

BodyPart& PartList::ellipsoid(Joint joint, Material material, const Vector3d& centre, const Vector3d& radii,
                              double blend) {
  BodyPart part;
  part.kind = BodyPart::Kind::ellipsoid;
  part.joint = joint;
  part.material = material;
  part.a = part.b = centre * scale_;
  part.radii = radii * scale_;
  part.blend = blend;
  return add(part);
}

namespace {

Vector3d at(double x, double y, double z) {
  return {x, y, z};
}

void add_chest(PartList& body, Side side) {
  const double s = sign_of(side), bust = body.build().bust, wide = body.build().proportions.shoulders;
  if (body.build().sex == Sex::male) {
    body.ellipsoid(Joint::chest, Material::shirt, at(0.048, s * 0.074 * wide, 1.310), at(0.052, 0.074, 0.058), 0.05);
  } else {
    const Vector3d radii = bust * at(0.056, 0.060, 0.058);
    body.ellipsoid(Joint::chest, Material::shirt, at(0.046 + 0.012 * bust, s * 0.071, 1.275), radii, 0.035);
  }
  body.ellipsoid(Joint::chest, Material::shirt, at(-0.080, s * 0.082 * wide, 1.340), at(0.038, 0.066, 0.090), 0.05);
}

// The slope from the neck to the shoulder, which goes with the collarbone.
void add_shoulder(PartList& body, Side side) {
  const Joint clavicle = on_side(Joint::clavicle_left, side);
  const double s = sign_of(side), k = body.scale(), thick = body.build().sex == Sex::male ? 1.0 : 0.82;
  const Vector3d tip = body.joint(Joint::upper_arm_left, side);
  body.cone(clavicle, Material::shirt, at(-0.030, s * 0.040, 1.462) * k, tip + at(-0.006, -s * 0.010, 0.006) * k,
            0.042 * thick, 0.046 * thick, 0.045);
  body.cone(Joint::neck, Material::skin, at(-0.040, s * 0.020, 1.515) * k, at(-0.034, s * 0.085, 1.458) * k,
            0.030 * thick, 0.030 * thick, 0.045);
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
    add_chest(body, side);
    add_shoulder(body, side);
  }
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
  add_head(body, HeadFrame(skeleton, build));
  for (const Side side : {Side::left, Side::right}) {
    add_hand(body, side);
    add_shoe(body, side);
  }
  for (auto& part : body.parts) bound(part);
  return body.parts;
}

}  // namespace rotunda::simulator
