#include "simulator/people/posture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "simulator/people/key_curve.h"

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// To the left about z, to the right about x, forwards about y; degrees.
Quaterniond turned(double left, double right, double forwards) {
  return Quaterniond(AngleAxisd(radians(left), Vector3d::UnitZ()) * AngleAxisd(radians(right), Vector3d::UnitX()) *
                     AngleAxisd(radians(forwards), Vector3d::UnitY()));
}

Quaterniond part_of(const Quaterniond& rotation, double part) {
  return Quaterniond::Identity().slerp(part, rotation);
}

// Against the chest. Upright in world while the pelvis leans less than 30 degrees, along with it from 80 on.
Quaterniond head_rotation(const Posture& posture, const Quaterniond& pelvis, const Quaterniond& trunk) {
  const double lean = std::acos(std::clamp((pelvis * Vector3d::UnitZ()).z(), -1.0, 1.0)) * 180.0 / std::numbers::pi;
  const Quaterniond upright = turned(posture.yaw, 0.0, 0.0);
  const Quaterniond along = part_of(upright.inverse() * pelvis, 0.15 + 0.85 * smooth_step((lean - 30.0) / 50.0));
  const Quaterniond head = upright * along * turned(posture.look, posture.head_tilt, posture.nod);
  Quaterniond against = (pelvis * trunk).inverse() * head;
  if (against.w() < 0.0) against.coeffs() *= -1.0;
  constexpr double kLimit = 80.0;  // degrees a neck turns (Norkin and White 2016), approached smoothly
  const double angle = AngleAxisd(against).angle() * 180.0 / std::numbers::pi;
  return angle < 1e-9 ? against : part_of(against, kLimit * std::tanh(angle / kLimit) / angle);
}

// The shoulder goes up when shrugged, and with an arm that is lifted above the horizontal (the scapula's share of the
// lift; Inman, Saunders and Abbott 1944).
void put_arm(const Skeleton& skeleton, Pose& pose, Side side, const ArmPosture& arm) {
  const double lifted = std::max(std::abs(arm.flexion), std::abs(arm.abduction)) - 60.0;
  const double up = arm.shrug + 14.0 * smooth_step(lifted / 110.0);
  pose.rotation[index(on_side(Joint::clavicle_left, side))] =
      Quaterniond(AngleAxisd(sign_of(side) * radians(up), Vector3d::UnitX()));
  place_arm(skeleton, pose, side,
            {.abduction = radians(arm.abduction),
             .flexion = radians(arm.flexion),
             .rotation = radians(arm.rotation),
             .elbow = radians(arm.elbow),
             .pronation = radians(arm.pronation),
             .wrist = radians(arm.wrist)});
  constexpr double kHanging = 18.0;  // degrees: one of curl_fingers' units
  curl_fingers(pose, side, arm.curl / kHanging);
}

}  // namespace

PostureValues values_of(const Posture& posture) {
  return std::bit_cast<PostureValues>(posture);
}

Posture posture_of(const PostureValues& values) {
  return std::bit_cast<Posture>(values);
}

Posture blend(const Posture& from, const Posture& to, double weight) {
  PostureValues a = values_of(from);
  const PostureValues b = values_of(to);
  for (std::size_t i = 0; i < kPostureValues; ++i) a[i] += weight * (b[i] - a[i]);
  return posture_of(a);
}

Posture mirrored(const Posture& posture) {
  Posture m = posture;
  std::swap(m.arm[0], m.arm[1]);
  std::swap(m.leg[0], m.leg[1]);
  for (double* turned_about : {&m.left, &m.yaw, &m.list, &m.twist, &m.side_bend, &m.look, &m.head_tilt})
    *turned_about = -*turned_about;
  return m;
}

double standing_height(const Skeleton& skeleton) {
  const double hip = skeleton.thigh_length() + skeleton.shank_length() + ankle_height(skeleton);
  return hip + skeleton.joint[index(Joint::pelvis)].z() - skeleton.joint[index(Joint::thigh_left)].z();
}

Pose trunk_pose(const Skeleton& skeleton, const Posture& posture, const Vector3d& pelvis) {
  Pose pose = bind_pose(skeleton);
  pose.pelvis = pelvis;
  const auto set = [&](Joint joint, const Quaterniond& rotation) { pose.rotation[index(joint)] = rotation; };
  const Quaterniond hips = turned(posture.yaw, posture.list, posture.tilt);
  const Quaterniond lower = turned(0.45 * posture.twist, 0.5 * posture.side_bend, 0.55 * posture.bend);
  const Quaterniond upper = turned(0.55 * posture.twist, 0.5 * posture.side_bend, 0.45 * posture.bend);
  const Quaterniond head = head_rotation(posture, hips, lower * upper);
  set(Joint::pelvis, hips);
  set(Joint::spine, lower);
  set(Joint::chest, upper);
  set(Joint::neck, part_of(head, 0.45));
  set(Joint::head, part_of(head, 0.55));
  for (const Side side : {Side::left, Side::right}) put_arm(skeleton, pose, side, posture.arm[at(side)]);
  return pose;
}

void stand_on(const Skeleton& skeleton, Pose& pose, const std::array<LegPlacement, 2>& legs) {
  pose.pelvis.z() = reachable_pelvis_height(skeleton, pose, legs);
  for (const Side side : {Side::left, Side::right}) place_leg(skeleton, pose, side, legs[at(side)]);
}

}  // namespace rotunda::simulator
