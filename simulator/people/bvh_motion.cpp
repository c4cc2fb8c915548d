#include "simulator/people/bvh_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "recon/body/bone_frame.h"
#include "simulator/people/bvh_skeleton.h"
#include "simulator/people/footfall.h"

namespace rotunda::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using recon::frame_of;
using recon::shortest_turn;
using Matrices = std::array<Matrix3d, kJoints>;

// Where the file's counterparts of our joints are in a frame; world orientation, file's unit.
struct SourceFrame {
  std::array<Vector3d, kJoints> position;
  Matrices rotation;  // of joints without counterpart undefined
};

SourceFrame source_frame(const BvhSkeleton& source, const std::vector<Isometry3d>& joints) {
  SourceFrame frame;
  for (std::size_t j = 0; j < kJoints; ++j) {
    if (source.joint[j] < 0) continue;
    const auto& joint = joints[static_cast<std::size_t>(source.joint[j])];
    frame.position[j] = source.world_from_file * joint.translation();
    frame.rotation[j] = source.world_from_file * joint.linear();
  }
  return frame;
}

// Where a bone's far end is.
Joint end_of(Joint bone) {
  return static_cast<Joint>(index(bone) + 1);  // limbs and spine are numbered from the trunk outwards
}

// For each joint with a counterpart the constant that makes ours of its rotation: world_from_ours = rotation *
// constant.
class Calibration {
 public:
  Calibration(const recon::BvhMotion& bvh, const BvhSkeleton& source, const Skeleton& skeleton)
      : bvh_(bvh), source_(source), skeleton_(skeleton) {
    ours_from_theirs.fill(Matrix3d::Identity());
    source.zero_pose_stands ? take_zero_pose() : take_motion();
  }
  Matrices ours_from_theirs;

 private:
  static Vector3d bone(const std::array<Vector3d, kJoints>& at, Joint joint) {
    return at[index(end_of(joint))] - at[index(joint)];
  }
  bool has_bone(Joint joint) const { return source_.has(joint) && source_.has(end_of(joint)); }
  void set(Joint joint, const SourceFrame& frame, const Matrix3d& world_from_ours) {
    ours_from_theirs[index(joint)] = frame.rotation[index(joint)].transpose() * world_from_ours;
  }

  void take_zero_pose() {
    const auto rest = source_frame(source_, recon::zero_pose(bvh_));
    for (std::size_t j = 0; j < kJoints; ++j)
      if (source_.joint[j] >= 0) set(static_cast<Joint>(j), rest, Matrix3d::Identity());
    for (const Side side : {Side::left, Side::right}) {
      for (const Joint left : {Joint::upper_arm_left, Joint::forearm_left, Joint::thigh_left, Joint::shank_left})
        turn_bone(on_side(left, side), rest);
      follow(on_side(Joint::hand_left, side), on_side(Joint::forearm_left, side), rest);
      turn_foot(side, rest);
    }
  }
  void turn_bone(Joint joint, const SourceFrame& rest) {
    if (has_bone(joint)) set(joint, rest, shortest_turn(bone(skeleton_.joint, joint), bone(rest.position, joint)));
  }
  void follow(Joint joint, Joint leader, const SourceFrame& frame) {
    if (source_.has(joint) && source_.has(leader))
      set(joint, frame, frame.rotation[index(leader)] * ours_from_theirs[index(leader)]);
  }
  // Feet stand flat in both: only the way they point counts.
  void turn_foot(Side side, const SourceFrame& rest) {
    const Joint foot = on_side(Joint::foot_left, side);
    if (!has_bone(foot)) return;
    Vector3d from = bone(skeleton_.joint, foot), to = bone(rest.position, foot);
    from.z() = to.z() = 0.0;
    set(foot, rest, shortest_turn(from, to));
    set(end_of(foot), rest, shortest_turn(from, to));
  }

  void take_motion() {
    const auto first = frame_at(0);
    take_trunk(first);
    for (const Side side : {Side::left, Side::right}) {
      take_hinge(on_side(Joint::thigh_left, side), axis_of_knee(side), first);
      take_foot(side, first);
      const Joint clavicle = on_side(Joint::clavicle_left, side), hand = on_side(Joint::hand_left, side);
      if (has_bone(clavicle))
        set_frame(clavicle, first, frame_of(bone(first.position, clavicle), chest_axis(first)),
                  frame_of(bone(skeleton_.joint, clavicle), Vector3d::UnitX()));
      take_hinge(on_side(Joint::upper_arm_left, side), axis_of_elbow(side), first);
      follow(hand, on_side(Joint::forearm_left, side), first);
    }
  }
  SourceFrame frame_at(std::size_t frame) const { return source_frame(source_, recon::joint_transforms(bvh_, frame)); }
  void set_frame(Joint joint, const SourceFrame& frame, const Matrix3d& theirs, const Matrix3d& ours) {
    if (source_.has(joint)) set(joint, frame, theirs * ours.transpose());
  }
  template <class At>
  Vector3d to_left(const At& at, Joint left) const {
    return at[index(left)] - at[index(on_side(left, Side::right))];
  }
  // Hips and shoulders give left and right, the joints above and below each other up and down.
  void take_trunk(const SourceFrame& first) {
    const Joint shoulder =
        source_.has(Joint::clavicle_left) && source_.has(Joint::clavicle_right)     ? Joint::clavicle_left
        : source_.has(Joint::upper_arm_left) && source_.has(Joint::upper_arm_right) ? Joint::upper_arm_left
                                                                                    : Joint::thigh_left;
    const Joint above = source_.has(Joint::spine) ? Joint::spine : Joint::chest;
    const Joint top = source_.has(Joint::neck) ? Joint::neck : Joint::head;
    const auto frame = [&](const auto& at, Joint lateral, Joint low, Joint high) {
      return frame_of(to_left(at, lateral), at[index(high)] - at[index(low)]);
    };
    const auto take = [&](Joint joint, Joint lateral, Joint low, Joint high) {
      if (source_.has(low) && source_.has(high))
        set_frame(joint, first, frame(first.position, lateral, low, high), frame(skeleton_.joint, lateral, low, high));
    };
    take(Joint::pelvis, Joint::thigh_left, Joint::pelvis, above);
    take(Joint::spine, Joint::thigh_left, Joint::spine, Joint::chest);
    take(Joint::chest, shoulder, Joint::chest, top);
    follow(Joint::neck, Joint::chest, first);
    follow(Joint::head, Joint::chest, first);
  }
  Vector3d chest_axis(const SourceFrame& frame) const {
    return frame.rotation[index(Joint::chest)] * ours_from_theirs[index(Joint::chest)] * Vector3d::UnitX();
  }
  Vector3d axis_of_knee(Side side) const {
    return {0.0, std::cos(skeleton_.leg_angle), sign_of(side) * std::sin(skeleton_.leg_angle)};
  }
  Vector3d axis_of_elbow(Side side) const {
    return {0.0, -std::cos(skeleton_.arm_angle), -sign_of(side) * std::sin(skeleton_.arm_angle)};
  }

  // Upper and lower part of a limb, in the frame in which it bends most; straight all along they follow the trunk.
  void take_hinge(Joint upper, const Vector3d& axis, const SourceFrame& first) {
    const Joint lower = end_of(upper);
    if (!has_bone(upper) || !has_bone(lower)) return;
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
    const Vector3d trunk_turn = best.rotation[index(Joint::pelvis)] * ours_from_theirs[index(Joint::pelvis)] * axis;
    const Vector3d seen =
        most > 0.15 ? Vector3d(bone(best.position, upper).cross(bone(best.position, lower))) : trunk_turn;
    for (const Joint part : {upper, lower})
      set_frame(part, best, frame_of(bone(best.position, part), seen), frame_of(bone(skeleton_.joint, part), axis));
  }
  // The ankle is bent at rest: shank and foot span the plane.
  void take_foot(Side side, const SourceFrame& first) {
    const Joint shank = on_side(Joint::shank_left, side), foot = on_side(Joint::foot_left, side);
    if (!has_bone(foot)) return follow(foot, shank, first);
    const auto frame = [&](const auto& at) { return frame_of(bone(at, foot), bone(at, shank).cross(bone(at, foot))); };
    set_frame(foot, first, frame(first.position), frame(skeleton_.joint));
    follow(end_of(foot), foot, first);
  }

  const recon::BvhMotion& bvh_;
  const BvhSkeleton& source_;
  const Skeleton& skeleton_;
};

// One that stands between two: half of the turn.
void fill_between(const BvhSkeleton& source, Joint joint, Joint below, Joint above,
                  std::array<Quaterniond, kJoints>& world) {
  if (!source.has(joint) && source.has(below) && source.has(above))
    world[index(joint)] = world[index(below)].slerp(0.5, world[index(above)]);
}

class Retargeting {
 public:
  Retargeting(const recon::BvhMotion& bvh, const BvhSkeleton& source, const Skeleton& skeleton)
      : source_(source),
        skeleton_(skeleton),
        calibration_(bvh, source, skeleton),
        at_rest_(bind_pose(skeleton)),
        scale_((skeleton.thigh_length() + skeleton.shank_length()) / source.leg) {
    for (const Side side : {Side::left, Side::right}) curl_fingers(at_rest_, side, 1.0);
  }

  Pose pose(const std::vector<Isometry3d>& joints) const {
    const auto frame = source_frame(source_, joints);
    std::array<Quaterniond, kJoints> world;
    world.fill(Quaterniond::Identity());
    for (std::size_t j = 0; j < kJoints; ++j)
      if (source_.joint[j] >= 0) world[j] = Quaterniond(Matrix3d(frame.rotation[j] * calibration_.ours_from_theirs[j]));
    fill_between(source_, Joint::spine, Joint::pelvis, Joint::chest, world);
    fill_between(source_, Joint::neck, Joint::chest, Joint::head, world);
    Pose pose = at_rest_;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const auto parent = index(parent_of(static_cast<Joint>(j)));
      const bool is_known = source_.joint[j] >= 0 || static_cast<Joint>(j) == Joint::spine ||
                            (static_cast<Joint>(j) == Joint::neck && source_.has(Joint::head));
      if (!is_known) world[j] = world[parent] * at_rest_.rotation[j];
      pose.rotation[j] = parent == j ? world[j] : (world[parent].conjugate() * world[j]).normalized();
    }
    pose.pelvis = scale_ * hips(frame.position) -
                  world[index(Joint::pelvis)] * (hips(skeleton_.joint) - skeleton_.joint[index(Joint::pelvis)]);
    return pose;
  }

 private:
  static Vector3d hips(const std::array<Vector3d, kJoints>& at) {
    return 0.5 * (at[index(Joint::thigh_left)] + at[index(Joint::thigh_right)]);
  }

  const BvhSkeleton& source_;
  const Skeleton& skeleton_;
  Calibration calibration_;
  Pose at_rest_;
  double scale_;
};

// Points of a sole in the bind pose, as fractions of the height about ankle and toes: heel, ball, tip.
struct Sole {
  double heel, ball, tip;  // heights in a pose
  double lowest() const { return std::min({heel, ball, tip}); }
};
Sole sole_of(const Skeleton& skeleton, const JointTransforms& transforms, Side side) {
  const Joint foot = on_side(Joint::foot_left, side), toes = on_side(Joint::toes_left, side);
  const auto height = [&](Joint joint, Joint carrier, double forward) {
    Vector3d point = skeleton.joint[index(joint)] + Vector3d(forward * skeleton.height, 0, 0);
    point.z() = 0.0;
    return (transforms[index(carrier)] * point).z();
  };
  return {height(foot, foot, -0.03), height(toes, foot, 0.0), height(toes, toes, 0.045)};
}

std::vector<HeelStrike> strikes_of(const Motion& motion, const Skeleton& skeleton, double frame_time) {
  const auto heels_at = [&](double seconds) -> std::array<double, 2> {
    const auto transforms = joint_transforms(skeleton, motion.pose_at(seconds));
    return {sole_of(skeleton, transforms, Side::left).heel, sole_of(skeleton, transforms, Side::right).heel};
  };
  return find_heel_strikes(heels_at, {.duration = motion.frames * kActStep,
                                      .is_cyclic = motion.is_cyclic,
                                      .person_height = skeleton.height,
                                      .step = std::max(0.005, 0.25 * frame_time)});
}

// On the floor is what the lowest sole does in the lower tenth of the frames: it may leave it, and a glitch may dip
// below.
void stand_on_floor(const Skeleton& skeleton, std::vector<Pose>& poses) {
  std::vector<double> lowest;
  for (const auto& pose : poses) {
    const auto transforms = joint_transforms(skeleton, pose);
    lowest.push_back(std::min(sole_of(skeleton, transforms, Side::left).lowest(),
                              sole_of(skeleton, transforms, Side::right).lowest()));
  }
  const auto tenth = lowest.begin() + static_cast<std::ptrdiff_t>(lowest.size() / 10);
  std::nth_element(lowest.begin(), tenth, lowest.end());
  for (auto& pose : poses) pose.pelvis.z() -= *tenth;
}

// The ground the path covers, metres.
Eigen::Vector2d centre(std::vector<Pose>& poses) {
  Eigen::AlignedBox3d box;
  for (const auto& pose : poses) box.extend(pose.pelvis);
  for (auto& pose : poses) pose.pelvis.head<2>() -= box.center().head<2>();
  return box.sizes().head<2>();
}

// For the user: cameras that stand about the middle may lose who goes far.
void tell_path(const Eigen::Vector2d& covered, std::vector<std::string>& notes) {
  constexpr double kAtTheSpot = 1.0;
  const Eigen::Vector2d stage(3.0, 2.0);
  if ((covered.array() < kAtTheSpot).all()) return;
  notes.push_back(fmt::format("its path covers {:.1f} x {:.1f} m{}", covered.x(), covered.y(),
                              (covered.array() > stage.array()).any()
                                  ? ", more than the stage of 3 x 2 m: no camera sees all of it"
                                  : ": --whole-volume gives the cameras lenses that hold all of the stage"));
}

Pose between(const Pose& a, const Pose& b, double share) {
  Pose pose;
  pose.pelvis = (1.0 - share) * a.pelvis + share * b.pelvis;
  for (std::size_t j = 0; j < kJoints; ++j) pose.rotation[j] = a.rotation[j].slerp(share, b.rotation[j]);
  return pose;
}

bool is_same(const Pose& a, const Pose& b) {
  constexpr double kApart = 0.005, kTurned = 0.01;  // metres, radians
  bool same = (a.pelvis - b.pelvis).norm() < kApart;
  for (std::size_t j = 0; j < kJoints; ++j) same = same && a.rotation[j].angularDistance(b.rotation[j]) < kTurned;
  return same;
}

}  // namespace

ImportedMotion import_motion(const recon::BvhMotion& bvh, const std::string& name, const Skeleton& skeleton) {
  const auto source = find_skeleton(bvh, name);
  const Retargeting retargeting(bvh, source, skeleton);
  std::vector<Pose> poses;
  for (std::size_t frame = 0; frame < bvh.frames; ++frame)
    poses.push_back(retargeting.pose(recon::joint_transforms(bvh, frame)));
  stand_on_floor(skeleton, poses);
  ImportedMotion imported;
  imported.notes = source.notes;
  tell_path(centre(poses), imported.notes);
  Motion& motion = imported.motion;
  motion.name = name;
  const double steps = bvh.duration() / kActStep, whole = std::round(steps);
  motion.is_cyclic =
      poses.size() == 1 || (std::abs(steps - whole) < 0.025 && whole > 0.0 && is_same(poses.front(), poses.back()));
  motion.frames = std::max(1, static_cast<int>(motion.is_cyclic ? whole : std::floor(steps + 1e-6) + 1));
  motion.pose_at = [poses = std::make_shared<const std::vector<Pose>>(std::move(poses)),
                    frame_time = bvh.frame_time](double seconds) {
    const double place = std::clamp(seconds / frame_time, 0.0, static_cast<double>(poses->size() - 1));
    const auto frame = std::min(static_cast<std::size_t>(place), poses->size() - 1),
               next = std::min(frame + 1, poses->size() - 1);
    return between((*poses)[frame], (*poses)[next], place - static_cast<double>(frame));
  };
  motion.heel_strikes = strikes_of(motion, skeleton, bvh.frame_time);
  return imported;
}

}  // namespace rotunda::simulator
