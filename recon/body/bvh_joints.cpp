#include "recon/body/bvh_joints.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "config/errors.h"
#include "recon/body/joint_names.h"
#include "recon/body/length_unit.h"

namespace rotunda::recon {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

std::optional<BodyJoint> left_limb_joint(BodySegment segment) {
  switch (segment) {
    case BodySegment::clavicle:
      return BodyJoint::clavicle_left;
    case BodySegment::upper_arm:
      return BodyJoint::upper_arm_left;
    case BodySegment::forearm:
      return BodyJoint::forearm_left;
    case BodySegment::hand:
      return BodyJoint::hand_left;
    case BodySegment::thigh:
      return BodyJoint::thigh_left;
    case BodySegment::shank:
      return BodyJoint::shank_left;
    case BodySegment::foot:
      return BodyJoint::foot_left;
    default:
      return std::nullopt;
  }
}

BodyJoint on_side(BodyJoint left_joint, Side side) {
  return side == Side::left ? left_joint : mirrored(left_joint);
}

// The joint of the spine that carries an arm; the uppermost if none is seen to.
std::size_t chest_among(const BvhMotion& bvh, const std::vector<int>& spine, const BvhJoints& skeleton) {
  for (const BodyJoint arm : {BodyJoint::upper_arm_left, BodyJoint::upper_arm_right})
    for (int j = skeleton.joint[index(arm)]; j >= 0; j = bvh.joints[static_cast<std::size_t>(j)].parent)
      if (const auto found = std::find(spine.begin(), spine.end(), j); found != spine.end())
        return static_cast<std::size_t>(found - spine.begin());
  return spine.size() - 1;
}

// Of a spine of several joints the one that carries the arms is our chest, one amid those below our spine; where neck
// and head are called spine too (Blender's Rigify) they are what goes on above.
void take_spine(const BvhMotion& bvh, const std::vector<int>& spine, BvhJoints& skeleton) {
  if (spine.empty()) return;
  const std::size_t chest = chest_among(bvh, spine, skeleton);
  skeleton.joint[index(BodyJoint::chest)] = spine[chest];
  if (chest > 0) skeleton.joint[index(BodyJoint::spine)] = spine[chest / 2];
  const std::size_t above = spine.size() - 1 - chest;
  if (skeleton.has(BodyJoint::head) || above == 0) return;
  skeleton.joint[index(BodyJoint::head)] = spine.back();
  if (!skeleton.has(BodyJoint::neck) && above > 1) skeleton.joint[index(BodyJoint::neck)] = spine[chest + 1];
}

void map_joints(const BvhMotion& bvh, BvhJoints& skeleton) {
  std::vector<std::string> names;
  std::vector<int> parents;
  for (const auto& joint : bvh.joints) {
    names.push_back(joint.is_end_site ? "" : joint.name);
    parents.push_back(joint.parent);
  }
  const auto named = name_joints(names, parents);
  std::vector<int> spine;
  skeleton.joint.fill(-1);
  const auto set = [&](BodyJoint ours, std::size_t theirs) {
    if (!skeleton.has(ours)) skeleton.joint[index(ours)] = static_cast<int>(theirs);
  };
  for (std::size_t j = 0; j < named.size(); ++j) {
    if (!named[j]) continue;
    if (named[j]->segment == BodySegment::pelvis) set(BodyJoint::pelvis, j);
    if (named[j]->segment == BodySegment::spine) spine.push_back(static_cast<int>(j));
    if (named[j]->segment == BodySegment::neck) set(BodyJoint::neck, j);
    if (named[j]->segment == BodySegment::head) set(BodyJoint::head, j);
    if (!named[j]->side) continue;
    if (const auto limb = left_limb_joint(named[j]->segment)) set(on_side(*limb, *named[j]->side), j);
    if (named[j]->segment == BodySegment::toes)
      skeleton.toes[*named[j]->side == Side::left ? 0 : 1] = static_cast<int>(j);
  }
  take_spine(bvh, spine, skeleton);
}

void require_joints(const BvhMotion& bvh, const std::string& name, const BvhJoints& skeleton) {
  for (const auto ours : {BodyJoint::pelvis, BodyJoint::thigh_left, BodyJoint::thigh_right, BodyJoint::shank_left,
                          BodyJoint::shank_right, BodyJoint::foot_left, BodyJoint::foot_right, BodyJoint::chest}) {
    if (skeleton.has(ours)) continue;
    std::vector<std::string> names;
    for (const auto& joint : bvh.joints)
      if (!joint.is_end_site && names.size() < 40) names.push_back(joint.name);
    throw InvalidInput(fmt::format("{}: none of its joints is named like the {}; they are: {}", name, to_string(ours),
                                   fmt::join(names, ", ")));
  }
}

class Placed {
 public:
  Placed(const BvhJoints& skeleton, const std::vector<Isometry3d>& joints) : skeleton_(skeleton), joints_(joints) {}
  Vector3d at(BodyJoint ours) const { return joints_[skeleton_.of(ours)].translation(); }
  Vector3d to_left() const { return at(BodyJoint::thigh_left) - at(BodyJoint::thigh_right); }
  Vector3d ankles() const { return 0.5 * (at(BodyJoint::foot_left) + at(BodyJoint::foot_right)); }
  Vector3d head() const {
    return at(skeleton_.has(BodyJoint::head)   ? BodyJoint::head
              : skeleton_.has(BodyJoint::neck) ? BodyJoint::neck
                                               : BodyJoint::chest);
  }
  Vector3d to_head() const { return head() - ankles(); }
  // The legs run down, the head is above, left is left: within 45 degrees.
  bool stands(const Vector3d& up) const {
    const auto along = [&](const Vector3d& v) { return v.dot(up) / std::max(v.norm(), 1e-12); };
    for (const Side side : {Side::left, Side::right}) {
      const Vector3d knee = at(on_side(BodyJoint::shank_left, side));
      if (along(at(on_side(BodyJoint::thigh_left, side)) - knee) < 0.7) return false;
      if (along(knee - at(on_side(BodyJoint::foot_left, side))) < 0.7) return false;
    }
    // Bones that all run along one axis have the head below the hips.
    const Vector3d hips = 0.5 * (at(BodyJoint::thigh_left) + at(BodyJoint::thigh_right));
    return along(head() - hips) > 0.7 && std::abs(along(to_left())) < 0.5 && to_left().norm() > 0.02 * to_head().norm();
  }

 private:
  const BvhJoints& skeleton_;
  const std::vector<Isometry3d>& joints_;
};

Vector3d nearest_axis(const Vector3d& v) {
  Eigen::Index axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return Vector3d::Unit(axis) * (v[axis] < 0.0 ? -1.0 : 1.0);
}

Vector3d mean_to_head(const BvhMotion& bvh, const BvhJoints& skeleton) {
  constexpr std::size_t kMoments = 100;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < kMoments; ++i)
    sum += Placed(skeleton, joint_transforms(bvh, i * bvh.frames / kMoments)).to_head().normalized();
  return sum;
}

// Rows: forward, left, up. Left is an axis of the file's where it is nearly one: hips are never quite even.
Matrix3d axes_from(const Vector3d& up, Vector3d left) {
  left = (left - up * up.dot(left)).normalized();
  if (left.dot(nearest_axis(left)) > std::cos(0.35)) left = nearest_axis(left);
  Matrix3d world_from_file;
  world_from_file << left.cross(up).transpose(), left.transpose(), up.transpose();
  return world_from_file;
}

void find_axes(const BvhMotion& bvh, const std::string& name, BvhJoints& skeleton) {
  const auto zero = zero_pose(bvh), first = joint_transforms(bvh, 0);
  const Placed at_zero(skeleton, zero), at_first(skeleton, first);
  Vector3d up = nearest_axis(at_zero.to_head());
  skeleton.zero_pose_stands = at_zero.stands(up);
  if (!skeleton.zero_pose_stands) up = nearest_axis(mean_to_head(bvh, skeleton));
  const Vector3d left = skeleton.zero_pose_stands ? at_zero.to_left() : at_first.to_left();
  if ((left - up * up.dot(left)).norm() < 1e-9 * std::max(1.0, left.norm()))
    throw InvalidInput(name + ": its hips lie above each other: which way it faces cannot be told");
  skeleton.world_from_file = axes_from(up, left);
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  skeleton.notes.push_back(fmt::format("{}{} is up; {}", up[axis] < 0.0 ? "-" : "", "xyz"[axis],
                                       skeleton.zero_pose_stands
                                           ? "its zero pose stands and is taken for ours"
                                           : "nobody stands in its zero pose: bones and bends seen in the motion are"));
}

void measure(const BvhMotion& bvh, const std::string& name, BvhJoints& skeleton) {
  const auto first = joint_transforms(bvh, 0);
  const Placed placed(skeleton, first);
  for (const Side side : {Side::left, Side::right}) {
    const Vector3d knee = placed.at(on_side(BodyJoint::shank_left, side));
    skeleton.leg += 0.5 * ((placed.at(on_side(BodyJoint::thigh_left, side)) - knee).norm() +
                           (knee - placed.at(on_side(BodyJoint::foot_left, side))).norm());
  }
  if (!(skeleton.leg > 1e-6)) throw InvalidInput(name + ": its legs have no length");
  constexpr double kMeanLeg = 0.85;      // Drillis, Contini 1966, at 1.73 m
  constexpr Plausible kLeg{0.55, 1.15};  // a child's, a very tall man's
  const auto unit = unit_of(skeleton.leg, kLeg, FileOf::motion);
  skeleton.metres = unit ? unit->metres : kMeanLeg / skeleton.leg;
  skeleton.notes.push_back(unit ? fmt::format("in {}: its leg is {:.2f} m", unit->name, skeleton.leg * unit->metres)
                                : fmt::format("in an unknown unit: its leg is {:.3g} of it", skeleton.leg));
}

}  // namespace

BvhJoints find_joints(const BvhMotion& bvh, const std::string& name) {
  BvhJoints skeleton;
  map_joints(bvh, skeleton);
  require_joints(bvh, name, skeleton);
  find_axes(bvh, name, skeleton);
  measure(bvh, name, skeleton);
  std::vector<int> used(skeleton.joint.begin(), skeleton.joint.end());
  used.insert(used.end(), skeleton.toes.begin(), skeleton.toes.end());
  std::vector<std::string> unused;
  for (std::size_t j = 0; j < bvh.joints.size(); ++j)
    if (!bvh.joints[j].is_end_site && std::find(used.begin(), used.end(), static_cast<int>(j)) == used.end())
      unused.push_back(bvh.joints[j].name);
  if (!unused.empty()) skeleton.notes.push_back(fmt::format("not used: {}", fmt::join(unused, ", ")));
  std::vector<std::string_view> still;
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    if (skeleton.joint[j] < 0) still.push_back(to_string(body_joint(j)));
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}})
    if (skeleton.toes[side] < 0) still.push_back(side == 0 ? "toes_left" : "toes_right");
  if (!still.empty()) skeleton.notes.push_back(fmt::format("no counterpart, kept still: {}", fmt::join(still, ", ")));
  return skeleton;
}

}  // namespace rotunda::recon
