#include "recon/body/body_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/errors.h"
#include "recon/body/bone_frame.h"
#include "recon/body/bvh_joints.h"

namespace rotunda::recon {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using enum BodyJoint;

using Matrices = std::array<Matrix3d, kBodyJoints>;
using Points = std::array<Vector3d, kBodyJoints>;

// Limbs and spine are numbered from the trunk outwards.
BodyJoint end_of(BodyJoint bone) {
  return body_joint(index(bone) + 1);
}

BodyJoint on_side(BodyJoint left, bool is_right) {
  return is_right ? mirrored(left) : left;
}

// Where a bone points in the T-pose all skeletons share.
Vector3d rest_bone(BodyJoint joint) {
  if (joint <= head) return Vector3d::UnitZ();
  if (joint <= hand_left) return Vector3d::UnitY();
  if (joint <= hand_right) return -Vector3d::UnitY();
  return joint == foot_left || joint == foot_right ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitZ());
}

// Where the file's counterparts of our joints are in a frame; world orientation, file's unit.
struct SourceFrame {
  Points position;
  Matrices rotation;             // of joints without counterpart undefined
  std::array<Vector3d, 2> toes;  // likewise
};

SourceFrame source_frame(const BvhJoints& source, const std::vector<Isometry3d>& joints) {
  SourceFrame frame;
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    if (source.joint[j] < 0) continue;
    const auto& joint = joints[static_cast<std::size_t>(source.joint[j])];
    frame.position[j] = source.world_from_file * joint.translation();
    frame.rotation[j] = source.world_from_file * joint.linear();
  }
  for (std::size_t side = 0; side < 2; ++side)
    if (source.toes[side] >= 0)
      frame.toes[side] = source.world_from_file * joints[static_cast<std::size_t>(source.toes[side])].translation();
  return frame;
}

// For each joint with a counterpart the constant that makes ours of its rotation: world_from_ours = rotation *
// constant.
class SharedPose {
 public:
  SharedPose(const BvhMotion& bvh, const BvhJoints& source) : bvh_(bvh), source_(source) {
    ours_from_theirs.fill(Matrix3d::Identity());
    source.zero_pose_stands ? take_zero_pose() : take_motion();
  }
  Matrices ours_from_theirs;

 private:
  static Vector3d bone(const Points& at, BodyJoint joint) { return at[index(end_of(joint))] - at[index(joint)]; }
  bool has_bone(BodyJoint joint) const { return source_.has(joint) && source_.has(end_of(joint)); }
  void set(BodyJoint joint, const SourceFrame& frame, const Matrix3d& world_from_ours) {
    ours_from_theirs[index(joint)] = frame.rotation[index(joint)].transpose() * world_from_ours;
  }
  void set_frame(BodyJoint joint, const SourceFrame& frame, const Matrix3d& theirs, const Matrix3d& ours) {
    if (source_.has(joint)) set(joint, frame, theirs * ours.transpose());
  }
  void follow(BodyJoint joint, BodyJoint leader, const SourceFrame& frame) {
    if (source_.has(joint) && source_.has(leader))
      set(joint, frame, frame.rotation[index(leader)] * ours_from_theirs[index(leader)]);
  }
  SourceFrame frame_at(std::size_t frame) const { return source_frame(source_, joint_transforms(bvh_, frame)); }

  void take_zero_pose() {
    const auto rest = source_frame(source_, zero_pose(bvh_));
    for (std::size_t j = 0; j < kBodyJoints; ++j)
      if (source_.joint[j] >= 0) set(body_joint(j), rest, Matrix3d::Identity());
    for (const bool right : {false, true}) {
      for (const auto left : {upper_arm_left, forearm_left, thigh_left, shank_left}) {
        const auto joint = on_side(left, right);
        if (has_bone(joint)) set(joint, rest, shortest_turn(rest_bone(joint), bone(rest.position, joint)));
      }
      follow(on_side(hand_left, right), on_side(forearm_left, right), rest);
      turn_foot(right, rest);
    }
  }
  // Feet stand flat in both: only the way they point counts.
  void turn_foot(bool right, const SourceFrame& rest) {
    const auto foot = on_side(foot_left, right);
    if (!source_.has(foot) || source_.toes[right] < 0) return;
    Vector3d to = rest.toes[right] - rest.position[index(foot)];
    to.z() = 0.0;
    set(foot, rest, shortest_turn(Vector3d::UnitX(), to));
  }

  void take_motion() {
    const auto first = frame_at(0);
    take_trunk(first);
    for (const bool right : {false, true}) {
      take_hinge(on_side(thigh_left, right), first);
      take_foot(right, first);
      const auto clavicle = on_side(clavicle_left, right);
      if (has_bone(clavicle)) {
        const Vector3d forward = first.rotation[index(chest)] * ours_from_theirs[index(chest)] * Vector3d::UnitX();
        set_frame(clavicle, first, frame_of(bone(first.position, clavicle), forward),
                  frame_of(rest_bone(clavicle), Vector3d::UnitX()));
      }
      take_hinge(on_side(upper_arm_left, right), first);
      follow(on_side(hand_left, right), on_side(forearm_left, right), first);
    }
  }
  // Hips and shoulders give left and right, the joints above and below each other up and down.
  void take_trunk(const SourceFrame& first) {
    const auto both = [&](BodyJoint left) { return source_.has(left) && source_.has(mirrored(left)); };
    const auto shoulder = both(clavicle_left) ? clavicle_left : both(upper_arm_left) ? upper_arm_left : thigh_left;
    const auto take = [&](BodyJoint joint, BodyJoint lateral, BodyJoint low, BodyJoint high) {
      if (!source_.has(low) || !source_.has(high)) return;
      const auto& at = first.position;
      const Vector3d to_left = at[index(lateral)] - at[index(mirrored(lateral))];
      set_frame(joint, first, frame_of(to_left, at[index(high)] - at[index(low)]),
                frame_of(Vector3d::UnitY(), Vector3d::UnitZ()));
    };
    take(pelvis, thigh_left, pelvis, source_.has(spine) ? spine : chest);
    take(spine, thigh_left, spine, chest);
    take(chest, shoulder, chest, source_.has(neck) ? neck : head);
    follow(neck, chest, first);
    follow(head, chest, first);
  }
  // Upper and lower part of a limb, in the frame in which it bends most; straight all along they follow the trunk.
  void take_hinge(BodyJoint upper, const SourceFrame& first) {
    const auto lower = end_of(upper);
    if (!has_bone(upper) || !has_bone(lower)) return;
    const Vector3d& axis = range_of(lower).hinge;
    SourceFrame best = first;
    double most = 0.0;
    const std::size_t step = std::max<std::size_t>(1, bvh_.frames / 500);
    for (std::size_t f = 0; f < bvh_.frames; f += step) {
      const auto frame = frame_at(f);
      const double bend =
          bone(frame.position, upper).normalized().cross(bone(frame.position, lower).normalized()).norm();
      if (bend <= most) continue;
      most = bend;
      best = frame;
    }
    const Vector3d with_trunk = best.rotation[index(pelvis)] * ours_from_theirs[index(pelvis)] * axis;
    const Vector3d seen =
        most > 0.15 ? Vector3d(bone(best.position, upper).cross(bone(best.position, lower))) : with_trunk;
    for (const auto part : {upper, lower})
      set_frame(part, best, frame_of(bone(best.position, part), seen), frame_of(rest_bone(part), axis));
  }
  // The ankle is bent at rest: shank and foot span the plane.
  void take_foot(bool right, const SourceFrame& first) {
    const auto shank = on_side(shank_left, right), foot = on_side(foot_left, right);
    if (!source_.has(foot) || source_.toes[right] < 0) return follow(foot, shank, first);
    Vector3d toes = first.toes[right] - first.position[index(foot)];
    // As far as the toes lie below the ankle: a foot of Drillis and Contini's, 0.077 forward and 0.023 down.
    const Vector3d ours(0.077, 0.0, -0.023);
    set_frame(foot, first, frame_of(toes, bone(first.position, shank).cross(toes)),
              frame_of(ours, rest_bone(shank).cross(ours)));
  }

  const BvhMotion& bvh_;
  const BvhJoints& source_;
};

// Turns of joints without counterpart: halfway between their neighbours, or with their parent.
void fill_unknown(const BvhJoints& source, std::array<Quaterniond, kBodyJoints>& world) {
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    if (source.joint[j] >= 0) continue;
    const auto joint = body_joint(j);
    world[j] = world[index(*parent_of(joint))];
    if ((joint == spine || joint == neck) && source.has(end_of(joint))) world[j] = world[j].slerp(0.5, world[j + 1]);
  }
}

Pose pose_of(const BvhJoints& source, const SharedPose& shared, const std::vector<Isometry3d>& joints) {
  const auto frame = source_frame(source, joints);
  std::array<Quaterniond, kBodyJoints> world;
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    if (source.joint[j] >= 0) world[j] = Quaterniond(Matrix3d(frame.rotation[j] * shared.ours_from_theirs[j]));
  fill_unknown(source, world);
  Pose pose = rest_pose();
  for (std::size_t j = 0; j < kBodyJoints; ++j) {
    const auto parent = parent_of(body_joint(j));
    pose.rotation[j] = parent ? (world[index(*parent)].conjugate() * world[j]).normalized() : world[j];
  }
  pose.root = 0.5 * source.metres * (frame.position[index(thigh_left)] + frame.position[index(thigh_right)]);
  return pose;
}

// A quarter of a turn at most in radians, next to nothing in degrees: nobody moves so little.
void refuse_radians(const BvhMotion& bvh, const BvhImportOptions& options) {
  const std::size_t width = bvh.channels();
  std::vector<bool> is_angle;
  for (const auto& joint : bvh.joints)
    for (const auto channel : joint.channels) is_angle.push_back(channel >= BvhChannel::x_rotation);
  double largest = 0.0;
  for (std::size_t i = 0; i < bvh.values.size(); ++i)
    if (is_angle[i % width]) largest = std::max(largest, std::abs(bvh.values[i]));
  if (options.trust_angles || bvh.frames < 2 || largest < 0.2 || largest > 2.0 * std::numbers::pi + 0.01) return;
  throw InvalidInput(fmt::format(
      "{}: no angle is larger than {:.2f}: these look like radians, and BVH has degrees. Multiply them by 57.2958, or "
      "say --trust-angles if the person hardly moves",
      options.name, largest));
}

// Soles as the legs have them, on the floor in all but a tenth of the frames; the path about the middle.
void place_on_floor(const BvhJoints& source, const BvhMotion& bvh, BodyMotion& motion) {
  std::vector<double> lowest;
  Eigen::AlignedBox3d path;
  for (std::size_t f = 0; f < bvh.frames; ++f) {
    const auto frame = source_frame(source, joint_transforms(bvh, f));
    double low = std::min(frame.position[index(foot_left)].z(), frame.position[index(foot_right)].z());
    lowest.push_back(source.metres * low);
    path.extend(motion.poses[f].root);
  }
  const auto tenth = lowest.begin() + static_cast<std::ptrdiff_t>(lowest.size() / 10);
  std::nth_element(lowest.begin(), tenth, lowest.end());
  // Ankle above the sole against hip to ankle: Drillis and Contini, 0.039 of 0.491.
  const double sole = *tenth - 0.039 / 0.491 * motion.leg_length;
  for (auto& pose : motion.poses) pose.root -= Vector3d(path.center().x(), path.center().y(), sole);
}

}  // namespace

BodyMotion import_bvh(const BvhMotion& bvh, const BvhImportOptions& options) {
  const auto source = find_joints(bvh, options.name);
  refuse_radians(bvh, options);
  const SharedPose shared(bvh, source);
  BodyMotion motion{
      .poses = {}, .frame_time = bvh.frame_time, .leg_length = source.leg * source.metres, .notes = source.notes};
  for (std::size_t f = 0; f < bvh.frames; ++f)
    motion.poses.push_back(pose_of(source, shared, joint_transforms(bvh, f)));
  place_on_floor(source, bvh, motion);
  return motion;
}

std::vector<Pose> poses_for(const BodyMotion& motion, const Skeleton& skeleton) {
  auto poses = motion.poses;
  const double scale = skeleton.leg_length() / motion.leg_length;
  for (auto& pose : poses) pose.root *= scale;
  return poses;
}

}  // namespace rotunda::recon
