#include "recon/body/body_template.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kAround = 16;  // vertices of a ring
constexpr std::size_t kRings = 7;    // and two poles

constexpr std::array<std::string_view, kBodyMeasures> kMeasureNames = {
    "trunk",          "neck",         "head",          "shoulders",       "hips",          "upper_arm",
    "forearm",        "hand",         "thigh",         "shank",           "foot",          "foot_height",
    "pelvis_breadth", "pelvis_depth", "waist_breadth", "waist_depth",     "chest_breadth", "chest_depth",
    "neck_width",     "head_breadth", "head_depth",    "upper_arm_width", "elbow_width",   "wrist_width",
    "hand_width",     "thigh_width",  "knee_width",    "calf_width",      "ankle_width",   "foot_width"};

// Fractions of the height in shoes, whose soles are 2 cm. Lengths: Drillis and Contini (1966), in Winter, Biomechanics
// and Motor Control of Human Movement, figure 4.1; what it leaves open (between the joints of the shoulders, of the
// hips; neck, head) as skinned body models have it (Loper et al. 2015). Widths: ANSUR II, mean of both sexes;
// circumferences over pi.
constexpr BodyMeasures kFractions = {0.285, 0.047, 0.1211, 0.204, 0.100, 0.186, 0.146, 0.108, 0.242, 0.2435,
                                     0.114, 0.050, 0.206,  0.142, 0.186, 0.135, 0.168, 0.148, 0.068, 0.089,
                                     0.114, 0.060, 0.054,  0.031, 0.050, 0.117, 0.074, 0.072, 0.042, 0.058};

constexpr std::array<BodyJoint, kBodySegments> kSegmentJoints = {
    BodyJoint::pelvis,         BodyJoint::spine,        BodyJoint::chest,       BodyJoint::neck,
    BodyJoint::upper_arm_left, BodyJoint::forearm_left, BodyJoint::hand_left,   BodyJoint::upper_arm_right,
    BodyJoint::forearm_right,  BodyJoint::hand_right,   BodyJoint::thigh_left,  BodyJoint::shank_left,
    BodyJoint::foot_left,      BodyJoint::thigh_right,  BodyJoint::shank_right, BodyJoint::foot_right};

// Where the trunk's joints are above the hips, as shares of its length: the spine's at the iliac crest (L4/L5), the
// chest's at T12/L1, the neck's a little above the shoulders; the pelvis' own above the line of the hips (Loper et
// al.).
constexpr double kPelvis = 0.05, kSpine = 0.28, kChest = 0.62, kNeck = 1.04;

struct Ring {
  Vector3d centre;
  Vector2d radii;  // along u and v
};

// Rings in order along the axis, u x v = axis, closed by a pole at either end.
BodySegmentSurface tube(const std::array<Ring, kRings>& rings, const Vector3d& u, const Vector3d& v,
                        const Vector3d& first_pole, const Vector3d& last_pole) {
  BodySegmentSurface surface;
  surface.vertices.push_back(first_pole);
  for (const auto& ring : rings)
    for (std::size_t k = 0; k < kAround; ++k) {
      const double phi = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kAround);
      surface.vertices.push_back(ring.centre + ring.radii.x() * std::cos(phi) * u + ring.radii.y() * std::sin(phi) * v);
    }
  surface.vertices.push_back(last_pole);
  return surface;
}

// What a segment is made from: three stations along its axis, round caps beyond the outer two.
struct Station {
  Vector3d centre;
  Vector2d radii;
};
struct Profile {
  Station first, middle, last;
  Vector3d u, v;
  double first_cap, last_cap;  // how far they reach beyond
};

Ring between(const Station& a, const Station& b) {
  constexpr double kBulge = 0.65;  // muscle: rounder than a cone
  return {0.5 * (a.centre + b.centre), (1.0 - kBulge) * a.radii.cwiseMin(b.radii) + kBulge * a.radii.cwiseMax(b.radii)};
}

BodySegmentSurface surface_of(const Profile& profile) {
  const Vector3d axis = profile.u.cross(profile.v);
  constexpr double kCapHeight = 0.70, kCapRadius = 0.71;  // a ring half way round an ellipsoid's quarter
  const auto& [first, middle, last, u, v, first_cap, last_cap] = profile;
  return tube(
      {Ring{first.centre - kCapHeight * first_cap * axis, kCapRadius * first.radii}, Ring{first.centre, first.radii},
       between(first, middle), Ring{middle.centre, middle.radii}, between(middle, last), Ring{last.centre, last.radii},
       Ring{last.centre + kCapHeight * last_cap * axis, kCapRadius * last.radii}},
      u, v, first.centre - first_cap * axis, last.centre + last_cap * axis);
}

// The other side's: y turned about, and the rings run the other way round.
BodySegmentSurface mirrored(const BodySegmentSurface& left) {
  BodySegmentSurface right = left;
  for (std::size_t ring = 0; ring < kRings; ++ring)
    for (std::size_t k = 0; k < kAround; ++k)
      right.vertices[1 + ring * kAround + k] = left.vertices[1 + ring * kAround + (kAround - k) % kAround];
  for (auto& vertex : right.vertices) vertex.y() = -vertex.y();
  return right;
}

struct Maker {
  const BodyMeasures& m;
  double of(BodyMeasure measure) const { return m[index(measure)]; }

  Skeleton skeleton() const;
  BodySegmentSurface pelvis() const;
  BodySegmentSurface abdomen() const;
  BodySegmentSurface chest() const;
  BodySegmentSurface head() const;
  BodySegmentSurface upper_arm() const;
  BodySegmentSurface forearm() const;
  BodySegmentSurface hand() const;
  BodySegmentSurface thigh() const;
  BodySegmentSurface shank() const;
  BodySegmentSurface foot() const;

 private:
  Vector2d half(BodyMeasure depth, BodyMeasure breadth, double share = 1.0) const {
    return 0.5 * share * Vector2d(of(depth), of(breadth));
  }
  Vector2d round(BodyMeasure width, double share = 1.0) const { return Vector2d::Constant(0.5 * share * of(width)); }
};

Skeleton Maker::skeleton() const {
  using enum BodyMeasure;
  Skeleton s;
  const double t = of(trunk), collar = 0.07 * of(shoulders);
  const auto put = [&](BodyJoint joint, double x, double y, double z) { s.offset[index(joint)] = {x, y, z}; };
  put(BodyJoint::pelvis, 0, 0, 0);
  put(BodyJoint::spine, 0, 0, (kSpine - kPelvis) * t);
  put(BodyJoint::chest, 0, 0, (kChest - kSpine) * t);
  put(BodyJoint::neck, 0, 0, (kNeck - kChest) * t);
  put(BodyJoint::head, 0.1 * of(head_depth), 0, of(neck));
  put(BodyJoint::clavicle_left, 0, collar, (1.0 - kChest) * t);
  put(BodyJoint::upper_arm_left, 0, 0.5 * of(shoulders) - collar, 0);
  put(BodyJoint::forearm_left, 0, of(upper_arm), 0);
  put(BodyJoint::hand_left, 0, of(BodyMeasure::forearm), 0);
  put(BodyJoint::thigh_left, 0, 0.5 * of(hips), -kPelvis * t);
  put(BodyJoint::shank_left, 0, 0, -of(BodyMeasure::thigh));
  put(BodyJoint::foot_left, 0, 0, -of(BodyMeasure::shank));
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    if (const auto other = index(rotunda::recon::mirrored(body_joint(j))); other > j)
      s.offset[other] = s.offset[j].cwiseProduct(Vector3d(1, -1, 1));
  s.crown = {0, 0, of(BodyMeasure::head)};
  s.fingertip = {0, of(BodyMeasure::hand), 0};
  s.toe = {of(BodyMeasure::foot), 0, -of(foot_height)};
  return s;
}

BodySegmentSurface Maker::pelvis() const {
  using enum BodyMeasure;
  const double t = of(trunk);
  return surface_of({.first = {{0, 0, (-0.10 - kPelvis) * t}, half(pelvis_depth, pelvis_breadth, 0.92)},
                     .middle = {{0, 0, (0.02 - kPelvis) * t}, half(pelvis_depth, pelvis_breadth)},
                     .last = {{0, 0, (0.20 - kPelvis) * t},
                              0.5 * (half(pelvis_depth, pelvis_breadth) + half(waist_depth, waist_breadth))},
                     .u = Vector3d::UnitX(),
                     .v = Vector3d::UnitY(),
                     .first_cap = 0.12 * t,
                     .last_cap = 0.08 * t});
}

BodySegmentSurface Maker::abdomen() const {
  using enum BodyMeasure;
  const double t = of(trunk);
  const auto waist = half(waist_depth, waist_breadth);
  return surface_of({.first = {{0, 0, (0.18 - kSpine) * t}, 0.5 * (half(pelvis_depth, pelvis_breadth) + waist)},
                     .middle = {{0, 0, (0.36 - kSpine) * t}, waist},
                     .last = {{0, 0, (0.56 - kSpine) * t}, 0.5 * (waist + half(chest_depth, chest_breadth))},
                     .u = Vector3d::UnitX(),
                     .v = Vector3d::UnitY(),
                     .first_cap = 0.08 * t,
                     .last_cap = 0.08 * t});
}

BodySegmentSurface Maker::chest() const {
  using enum BodyMeasure;
  const double t = of(trunk);
  return surface_of(
      {.first = {{0, 0, (0.52 - kChest) * t},
                 0.5 * (half(waist_depth, waist_breadth) + half(chest_depth, chest_breadth))},
       .middle = {{0, 0, (0.75 - kChest) * t}, half(chest_depth, chest_breadth)},
       .last = {{0, 0, (0.95 - kChest) * t}, half(chest_depth, chest_breadth).cwiseProduct(Vector2d(0.75, 1.0))},
       .u = Vector3d::UnitX(),
       .v = Vector3d::UnitY(),
       .first_cap = 0.08 * t,
       .last_cap = 0.14 * t});
}

// The neck's rings, then the head's: the only segment with a waist.
BodySegmentSurface Maker::head() const {
  using enum BodyMeasure;
  const double base = of(neck), length = of(BodyMeasure::head), x = 0.1 * of(head_depth);
  const auto radii = half(head_depth, head_breadth), collar = round(neck_width);
  const auto at = [&](double share, double size) { return Ring{{x, 0, base + share * length}, size * radii}; };
  return tube({Ring{{0, 0, -0.5 * base}, 1.15 * collar}, Ring{{0.5 * x, 0, 0.4 * base}, collar}, at(-0.10, 0.78),
               at(0.30, 0.96), at(0.55, 1.0), at(0.80, 0.84), at(0.94, 0.50)},
              Vector3d::UnitX(), Vector3d::UnitY(), {0, 0, -1.0 * base}, {x, 0, base + length});
}

BodySegmentSurface Maker::upper_arm() const {
  using enum BodyMeasure;
  const double length = of(BodyMeasure::upper_arm);
  return surface_of({.first = {{0, 0, 0}, round(upper_arm_width, 1.08)},
                     .middle = {{0, 0.40 * length, 0}, round(upper_arm_width)},
                     .last = {{0, length, 0}, round(elbow_width, 0.95)},
                     .u = Vector3d::UnitZ(),
                     .v = Vector3d::UnitX(),
                     .first_cap = 0.5 * of(upper_arm_width),
                     .last_cap = 0.4 * of(elbow_width)});
}

BodySegmentSurface Maker::forearm() const {
  using enum BodyMeasure;
  const double length = of(BodyMeasure::forearm);
  return surface_of({.first = {{0, 0, 0}, round(elbow_width, 0.95)},
                     .middle = {{0, 0.28 * length, 0}, round(elbow_width)},
                     .last = {{0, length, 0}, round(wrist_width)},
                     .u = Vector3d::UnitZ(),
                     .v = Vector3d::UnitX(),
                     .first_cap = 0.4 * of(elbow_width),
                     .last_cap = 0.3 * of(wrist_width)});
}

// Flat, the palm down.
BodySegmentSurface Maker::hand() const {
  using enum BodyMeasure;
  const double length = of(BodyMeasure::hand), width = of(hand_width);
  return surface_of({.first = {{0, 0.05 * length, 0}, {0.22 * width, 0.38 * width}},
                     .middle = {{0, 0.45 * length, 0}, {0.24 * width, 0.50 * width}},
                     .last = {{0, 0.90 * length, 0}, {0.14 * width, 0.32 * width}},
                     .u = Vector3d::UnitZ(),
                     .v = Vector3d::UnitX(),
                     .first_cap = 0.1 * length,
                     .last_cap = 0.1 * length});
}

BodySegmentSurface Maker::thigh() const {
  using enum BodyMeasure;
  const double length = of(BodyMeasure::thigh);
  return surface_of({.first = {{0, 0, 0}, round(thigh_width)},
                     .middle = {{0, 0, -0.22 * length}, round(thigh_width)},
                     .last = {{0, 0, -length}, round(knee_width)},
                     .u = Vector3d::UnitY(),
                     .v = Vector3d::UnitX(),
                     .first_cap = 0.35 * of(thigh_width),
                     .last_cap = 0.35 * of(knee_width)});
}

BodySegmentSurface Maker::shank() const {
  using enum BodyMeasure;
  const double length = of(BodyMeasure::shank);
  return surface_of({.first = {{0, 0, 0}, round(knee_width)},
                     .middle = {{0, 0, -0.30 * length}, round(calf_width)},
                     .last = {{0, 0, -length}, round(ankle_width)},
                     .u = Vector3d::UnitY(),
                     .v = Vector3d::UnitX(),
                     .first_cap = 0.35 * of(knee_width),
                     .last_cap = 0.4 * of(ankle_width)});
}

// From behind the heel to the toes, the sole flat on the floor.
BodySegmentSurface Maker::foot() const {
  using enum BodyMeasure;
  const double length = of(BodyMeasure::foot), height = of(foot_height), width = of(foot_width);
  const auto at = [&](double x, double thickness, double breadth) {
    return Station{{x * length, 0, -height + 0.5 * thickness * height},
                   {0.5 * breadth * width, 0.5 * thickness * height}};
  };
  return surface_of({.first = at(-0.32, 1.0, 0.72),
                     .middle = at(0.30, 1.15, 0.90),
                     .last = at(0.90, 0.50, 0.75),
                     .u = Vector3d::UnitY(),
                     .v = Vector3d::UnitZ(),
                     .first_cap = 0.10 * length,
                     .last_cap = 0.10 * length});
}

void check(const BodyMeasures& measures) {
  for (std::size_t i = 0; i < kBodyMeasures; ++i)
    if (!std::isfinite(measures[i]) || measures[i] <= 0.0)
      throw InvalidInput(
          fmt::format("body measure {} is {} m; it must be longer than nothing", kMeasureNames[i], measures[i]));
}

std::vector<std::array<std::uint32_t, 3>> make_segment_triangles() {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto at = [](std::size_t ring, std::size_t k) {
    return static_cast<std::uint32_t>(1 + ring * kAround + k % kAround);
  };
  const auto last_pole = static_cast<std::uint32_t>(1 + kRings * kAround);
  for (std::size_t k = 0; k < kAround; ++k) {
    triangles.push_back({0, at(0, k + 1), at(0, k)});
    for (std::size_t ring = 0; ring + 1 < kRings; ++ring) {
      triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k)});
      triangles.push_back({at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)});
    }
    triangles.push_back({last_pole, at(kRings - 1, k), at(kRings - 1, k + 1)});
  }
  return triangles;
}

}  // namespace

std::string_view to_string(BodyMeasure measure) {
  return kMeasureNames[index(measure)];
}

BodyMeasures measures_of_height(double height) {
  BodyMeasures measures = kFractions;
  for (auto& measure : measures) measure *= height;
  return measures;
}

double height_of(const BodyMeasures& measures) {
  using enum BodyMeasure;
  double height = 0.0;
  for (const auto measure : {foot_height, shank, thigh, neck, head}) height += measures[index(measure)];
  return height + kNeck * measures[index(trunk)];
}

double root_height_of(const BodyMeasures& measures) {
  using enum BodyMeasure;
  double height = kPelvis * measures[index(trunk)];
  for (const auto measure : {foot_height, shank, thigh}) height += measures[index(measure)];
  return height;
}

BodyJoint joint_of_segment(std::size_t segment) {
  return kSegmentJoints[segment];
}

const std::vector<std::array<std::uint32_t, 3>>& segment_triangles() {
  static const auto triangles = make_segment_triangles();
  return triangles;
}

std::size_t vertices_of_segment() {
  return kRings * kAround + 2;
}

BodyTemplate make_template(const BodyMeasures& measures) {
  check(measures);
  const Maker maker{measures};
  BodyTemplate body{.measures = measures, .skeleton = maker.skeleton(), .segments = {}};
  body.segments = {maker.pelvis(),
                   maker.abdomen(),
                   maker.chest(),
                   maker.head(),
                   maker.upper_arm(),
                   maker.forearm(),
                   maker.hand(),
                   {},
                   {},
                   {},
                   maker.thigh(),
                   maker.shank(),
                   maker.foot()};
  for (std::size_t s = 0; s < 3; ++s) {
    body.segments[7 + s] = mirrored(body.segments[4 + s]);
    body.segments[13 + s] = mirrored(body.segments[10 + s]);
  }
  return body;
}

TriangleMesh pose_template(const BodyTemplate& body, const Pose& pose) {
  TriangleMesh mesh;
  const auto transforms = joint_transforms(body.skeleton, pose);
  for (std::size_t s = 0; s < kBodySegments; ++s) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto& world_from_joint = transforms[index(kSegmentJoints[s])];
    for (const auto& vertex : body.segments[s].vertices)
      mesh.positions.push_back((world_from_joint * vertex).cast<float>());
    for (const auto& [a, b, c] : segment_triangles()) mesh.triangles.push_back({first + a, first + b, first + c});
  }
  compute_normals(mesh);
  return mesh;
}

std::vector<std::uint8_t> triangle_segments() {
  std::vector<std::uint8_t> segments;
  for (std::size_t s = 0; s < kBodySegments; ++s)
    segments.insert(segments.end(), segment_triangles().size(), static_cast<std::uint8_t>(s));
  return segments;
}

}  // namespace rotunda::recon
