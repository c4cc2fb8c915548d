// Legs, shoes, arms and hands.
#include <array>

#include "simulator/people/body_part_list.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;

Vector3d at(double x, double y, double z) {
  return {x, y, z};
}

constexpr double kInLine = 0.005;  // blend of pieces that follow one another: a wider one would thicken the joint

// A finger from its knuckle joint: radii at knuckle, next joint and tip, and how far the tip lies beyond the next
// joint; metres at 1.75 m (hand breadth and finger lengths of ISO 7250-2, men).
struct Finger {
  Joint first;
  double root, middle, tip, length;
};
constexpr std::array<Finger, 5> kFingers = {{{Joint::thumb1_left, 0.0145, 0.0102, 0.0078, 0.036},
                                             {Joint::index1_left, 0.0100, 0.0085, 0.0066, 0.040},
                                             {Joint::middle1_left, 0.0102, 0.0086, 0.0067, 0.044},
                                             {Joint::ring1_left, 0.0096, 0.0081, 0.0063, 0.041},
                                             {Joint::little1_left, 0.0086, 0.0072, 0.0056, 0.032}}};

void add_finger(PartList& body, Side side, const Finger& finger) {
  const auto next = static_cast<Joint>(index(finger.first) + 1);
  const Vector3d knuckle = body.joint(finger.first, side), middle = body.joint(next, side);
  const bool is_thumb = finger.first == Joint::thumb1_left;
  const double slim = body.build().sex == Sex::male ? 1.0 : 0.93;
  const Vector3d tip = middle + finger.length * body.scale() * (middle - knuckle).normalized();
  body.cone(on_side(finger.first, side), Material::skin, knuckle, middle, finger.root * slim, finger.middle * slim,
            is_thumb ? 0.012 : 0.004);
  body.cone(on_side(next, side), Material::skin, middle, tip, finger.middle * slim, finger.tip * slim, 0.003);
}

}  // namespace

// Radii of the bare limb (girths of ISO 7250-2 and NASA-STD-3000 over 2 pi); trousers stand off by `ease` times the
// second number of each station.
void add_leg(PartList& body, Side side) {
  const double s = sign_of(side), k = body.scale(), ease = body.build().ease, thick = body.build().limbs;
  const bool male = body.build().sex == Sex::male;
  const Joint thigh = on_side(Joint::thigh_left, side), shank = on_side(Joint::shank_left, side);
  const Vector3d hip = body.joint(Joint::thigh_left, side), knee = body.joint(Joint::shank_left, side);
  const Vector3d ankle = body.joint(Joint::foot_left, side);
  const auto r = [&](double bare, double off) { return bare * thick + off * ease; };
  const Vector3d seat = male ? at(0.078, 0.080, 0.088) : at(0.084, 0.086, 0.094);
  body.ellipsoid(Joint::pelvis, Material::trousers, at(-0.052, s * 0.070 * body.build().proportions.hips, 0.905), seat,
                 0.04);
  const Vector3d middle = hip + 0.45 * (knee - hip) + at(0.010, s * 0.004, 0) * k;
  body.cone(thigh, Material::trousers, hip - at(0.004, 0, 0.02) * k, middle, r(male ? 0.084 : 0.088, 0.004),
            r(male ? 0.073 : 0.075, 0.006), 0.03);
  body.cone(thigh, Material::trousers, middle, knee + at(0.004, 0, 0) * k, r(male ? 0.074 : 0.076, 0.006),
            r(0.055, 0.010), kInLine);
  const auto down = [&](double share, double back) -> Vector3d {
    return knee + share * (ankle - knee) - at(back, 0, 0) * k;
  };
  body.cone(shank, Material::trousers, knee, down(0.28, 0.013), r(0.054, 0.010), r(0.056, 0.012), kInLine);
  body.cone(shank, Material::trousers, down(0.28, 0.013), down(0.66, 0.008), r(0.056, 0.012), r(0.041, 0.020), kInLine);
  auto& hem = body.cone(shank, Material::trousers, down(0.66, 0.008), ankle - at(0.006, 0, 0) * k, r(0.041, 0.020),
                        r(0.035, 0.028), kInLine);
  hem.open_end = true;
}

void add_shoe(PartList& body, Side side) {
  const double s = sign_of(side), scale = body.scale();
  const auto on = [&](Joint left) { return on_side(left, side); };
  const Vector3d ankle = body.joint(Joint::foot_left, side), toes = body.joint(Joint::toes_left, side);
  const auto from_ankle = [&](double x, double y, double z) -> Vector3d {
    return at(ankle.x() + x * scale, ankle.y() + s * y * scale, z * scale);
  };
  body.cone(on(Joint::foot_left), Material::shoe, ankle - at(0.006, 0, 0.006) * scale, from_ankle(-0.016, 0, 0.050),
            0.038, 0.040, 0.006);
  body.cone(on(Joint::foot_left), Material::shoe, from_ankle(-0.030, 0, 0.045), from_ankle(0.07, 0.0, 0.048), 0.036,
            0.037, 0.012);
  body.cone(on(Joint::foot_left), Material::shoe, from_ankle(0.06, 0.0, 0.049), from_ankle(0.135, 0.003, 0.037), 0.037,
            0.034, 0.012);
  auto& toe = body.cone(on(Joint::toes_left), Material::shoe, from_ankle(0.125, 0.004, 0.035),
                        from_ankle(0.182, 0.0, 0.031), 0.034, 0.025, 0.012);
  toe.across = Vector3d::UnitY();
  toe.flatness = 1.28;
  auto& counter = body.cone(on(Joint::foot_left), Material::shoe, from_ankle(-0.031, 0, 0.030),
                            from_ankle(0.125, 0.002, 0.030), 0.0325, 0.0395, 0.008);  // the upper stands on the sole
  auto& rand = body.cone(on(Joint::toes_left), Material::shoe, from_ankle(0.125, 0.002, 0.028),
                         from_ankle(0.180, 0.0, 0.026), 0.0395, 0.0300, 0.008);
  for (auto* low : {&counter, &rand}) low->across = Vector3d::UnitZ(), low->flatness = 0.60;
  for (const double front : {0.0, 1.0}) {  // the sole, in two pieces that bend at the ball
    auto& sole = body.cone(front > 0 ? on(Joint::toes_left) : on(Joint::foot_left), Material::sole,
                           front > 0 ? Vector3d(toes.x(), toes.y(), 0.012 * scale) : from_ankle(-0.032, 0, 0.012),
                           front > 0 ? from_ankle(0.180, 0, 0.012) : from_ankle(0.125, 0, 0.012),
                           front > 0 ? 0.0425 : 0.0345, front > 0 ? 0.0325 : 0.0415, 0.004);
    sole.across = Vector3d::UnitZ();
    sole.flatness = 0.30;
  }
}

void add_arm(PartList& body, Side side) {
  const double k = body.scale(), ease = body.build().ease;
  const double thick = body.build().limbs * (body.build().sex == Sex::male ? 1.0 : 0.84);
  const Joint upper = on_side(Joint::upper_arm_left, side), fore = on_side(Joint::forearm_left, side);
  const Vector3d shoulder = body.joint(Joint::upper_arm_left, side), elbow = body.joint(Joint::forearm_left, side);
  const Vector3d wrist = body.joint(Joint::hand_left, side);
  const auto r = [&](double bare, double off) { return bare * thick + off * ease; };
  const auto down = [&](double share, double front) -> Vector3d {
    return shoulder + share * (elbow - shoulder) + at(front, 0, 0) * k;
  };
  // The deltoid lies under the tip of the shoulder, which stays the highest when the arm hangs.
  body.cone(upper, Material::shirt, down(0.04, 0), down(0.30, 0.002), r(0.0495, 0.002), r(0.049, 0.006), 0.040);
  body.cone(upper, Material::shirt, down(0.30, 0.002), down(0.60, 0.006), r(0.049, 0.006), r(0.045, 0.009), kInLine);
  body.cone(upper, Material::shirt, down(0.60, 0.006), elbow, r(0.045, 0.009), r(0.0385, 0.014), kInLine);
  const auto bony = [&](double radius) { return radius * (0.45 + 0.55 * thick); };  // wrists vary less than muscles
  const Vector3d bulge = elbow + 0.24 * (wrist - elbow), taper = elbow + 0.72 * (wrist - elbow);
  body.cone(fore, Material::skin, elbow, bulge, 0.0385 * thick, 0.0415 * thick, kInLine);
  body.cone(fore, Material::skin, bulge, taper, 0.0415 * thick, bony(0.0325), kInLine);
  auto& lower = body.cone(fore, Material::skin, taper, wrist, bony(0.0325), bony(0.0295), 0.010);
  lower.across = (wrist - elbow).normalized().cross(Vector3d::UnitX());
  lower.flatness = 0.80;
  if (ease <= 0.0) return;
  const Vector3d sleeve_end = elbow + 0.16 * (wrist - elbow);
  auto& sleeve = body.cone(fore, Material::shirt, elbow, sleeve_end, r(0.037, 0.014), r(0.040, 0.013), 0.010);
  sleeve.open_end = true;
}

void add_hand(PartList& body, Side side) {
  const Joint hand = on_side(Joint::hand_left, side);
  const double scale = body.scale(), broad = body.build().sex == Sex::male ? 1.0 : 0.92;
  const Vector3d wrist = body.joint(Joint::hand_left, side);
  const Vector3d out = (wrist - body.joint(Joint::forearm_left, side)).normalized();
  const Vector3d palm_normal = sign_of(side) * out.cross(Vector3d::UnitX());
  const auto place = [&](double along, double across, double palm) -> Vector3d {
    return wrist + scale * (along * out + across * Vector3d::UnitX() + palm * palm_normal);
  };
  auto& back = body.cone(hand, Material::skin, place(-0.006, 0, 0), place(0.078, 0.000, 0), 0.0285 * broad,
                         0.040 * broad, 0.030);
  back.across = palm_normal;
  back.flatness = 0.40;
  body.cone(hand, Material::skin, place(0.030, 0.016, 0.006), place(0.062, 0.026, 0.006), 0.0150, 0.0105, 0.014);
  body.cone(hand, Material::skin, place(0.030, -0.020, 0.004), place(0.066, -0.024, 0.004), 0.0135, 0.0100, 0.014);
  for (const auto& finger : kFingers) add_finger(body, side, finger);
}

}  // namespace rotunda::simulator
