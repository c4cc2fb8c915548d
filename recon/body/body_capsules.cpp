#include "recon/body/body_capsules.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;

struct Capsule {
  BodyJoint joint;  // that carries it
  Vector3d from, to;
  double radius;
};

enum CapsuleName : std::size_t {
  trunk,
  hips,
  left_upper_arm,
  left_forearm,
  right_upper_arm,
  right_forearm,
  left_thigh,
  left_shank,
  right_thigh,
  right_shank,
  capsule_count
};

std::array<Capsule, capsule_count> capsules_of(const BodyTemplate& body, const JointTransforms& at) {
  const auto width = [&](BodyMeasure measure) { return 0.5 * body.measures[index(measure)]; };
  const auto bone = [&](BodyJoint from, BodyJoint to, double radius) {
    return Capsule{from, at[index(from)].translation(), at[index(to)].translation(), radius};
  };
  using enum BodyMeasure;
  return {Capsule{BodyJoint::chest, at[index(BodyJoint::spine)].translation(),
                  at[index(BodyJoint::chest)] * Vector3d(0, 0, 0.6 * body.skeleton.offset[index(BodyJoint::neck)].z()),
                  width(chest_depth)},
          Capsule{BodyJoint::pelvis, at[index(BodyJoint::pelvis)].translation(),
                  at[index(BodyJoint::spine)].translation(), width(pelvis_depth)},
          bone(BodyJoint::upper_arm_left, BodyJoint::forearm_left, width(upper_arm_width)),
          bone(BodyJoint::forearm_left, BodyJoint::hand_left, width(elbow_width)),
          bone(BodyJoint::upper_arm_right, BodyJoint::forearm_right, width(upper_arm_width)),
          bone(BodyJoint::forearm_right, BodyJoint::hand_right, width(elbow_width)),
          bone(BodyJoint::thigh_left, BodyJoint::shank_left, width(knee_width)),
          bone(BodyJoint::shank_left, BodyJoint::foot_left, width(knee_width)),
          bone(BodyJoint::thigh_right, BodyJoint::shank_right, width(knee_width)),
          bone(BodyJoint::shank_right, BodyJoint::foot_right, width(knee_width))};
}

constexpr std::array<std::pair<CapsuleName, CapsuleName>, 17> kPairs = {{{trunk, left_forearm},
                                                                         {trunk, right_forearm},
                                                                         {hips, left_forearm},
                                                                         {hips, right_forearm},
                                                                         {trunk, left_thigh},
                                                                         {trunk, right_thigh},
                                                                         {left_forearm, right_forearm},
                                                                         {left_forearm, right_upper_arm},
                                                                         {right_forearm, left_upper_arm},
                                                                         {left_forearm, left_thigh},
                                                                         {left_forearm, right_thigh},
                                                                         {right_forearm, left_thigh},
                                                                         {right_forearm, right_thigh},
                                                                         {left_thigh, right_thigh},
                                                                         {left_shank, right_shank},
                                                                         {left_shank, right_thigh},
                                                                         {right_shank, left_thigh}}};

// Nearest points of two stretches (Ericson, Real-Time Collision Detection, 5.1.9).
std::pair<Vector3d, Vector3d> nearest(const Capsule& a, const Capsule& b) {
  const Vector3d d1 = a.to - a.from, d2 = b.to - b.from, r = a.from - b.from;
  const double A = d1.squaredNorm(), E = d2.squaredNorm(), F = d2.dot(r), C = d1.dot(r), B = d1.dot(d2);
  const double denominator = A * E - B * B;
  double s = denominator > 1e-12 ? std::clamp((B * F - C * E) / denominator, 0.0, 1.0) : 0.5;
  double t = (B * s + F) / E;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((B * t - C) / A, 0.0, 1.0);
  }
  return {a.from + s * d1, b.from + t * d2};
}

Vector3d world_axis(const Twist& twist, const JointTransforms& at) {
  const auto parent = parent_of(twist.joint);
  if (twist.kind == Twist::Kind::translation) return twist.axis;
  const bool of_parent = twist.kind == Twist::Kind::parent_axis && parent;
  return at[index(of_parent ? *parent : twist.joint)].linear() * twist.axis;
}

void add_point(std::map<std::uint16_t, double>& row, BodyJoint joint, const Vector3d& point, const Vector3d& along,
               const JointTransforms& at) {
  for (const auto k : twists_of(joint)) {
    const auto& twist = pose_twists()[k];
    const Vector3d axis = world_axis(twist, at);
    row[k] += twist.kind == Twist::Kind::translation
                  ? along.dot(axis)
                  : along.dot(axis.cross(point - at[index(twist.joint)].translation()));
  }
}

}  // namespace

void add_capsules(NormalEquations& equations, const BodyTemplate& body, const Pose& pose) {
  constexpr double kGiven = 0.02, kSigma = 0.01;  // metres: flesh and cloth give way; what is beyond, hardly
  const auto at = joint_transforms(body.skeleton, pose);
  const auto capsules = capsules_of(body, at);
  for (const auto& [first, second] : kPairs) {
    const auto &a = capsules[first], &b = capsules[second];
    const auto [on_a, on_b] = nearest(a, b);
    const double apart = (on_a - on_b).norm(), overlap = a.radius + b.radius - kGiven - apart;
    if (overlap <= 0.0 || apart < 1e-6) continue;
    const Vector3d along = (on_a - on_b) / apart;
    std::map<std::uint16_t, double> row;
    add_point(row, a.joint, on_a, -along, at);
    add_point(row, b.joint, on_b, along, at);
    std::vector<std::uint16_t> columns;
    std::vector<double> values;
    for (const auto& [column, value] : row) {
      columns.push_back(column);
      values.push_back(value);
    }
    equations.add(columns, values.data(), overlap, 1.0 / (kSigma * kSigma));
  }
}

}  // namespace rotunda::recon
