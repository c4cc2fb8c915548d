#include "simulator/people/bvh_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "config/errors.h"
#include "recon/body/joint_names.h"

namespace rotunda::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using recon::BodySegment;
using recon::BvhChannel;
using testing::Contains;
using testing::HasSubstr;

bool is_finger(Joint joint) {
  const auto name = to_string(joint);
  return name.find("1_") != std::string_view::npos || name.find("2_") != std::string_view::npos;
}

// How somebody else writes motions down.
struct Convention {
  std::map<Joint, std::string> names;  // of left limbs; "Left" becomes "Right"; joints without name are left out
  Matrix3d file_from_world = Matrix3d::Identity();
  double unit = 1.0;  // of the file, a metre
  std::array<int, 3> order = {2, 0, 1};
  bool positions_everywhere = false;
  std::array<Matrix3d, kJoints> file_from_bind;  // of each joint's frame: what the file calls zero
};

Matrix3d y_up() {
  Matrix3d turn;  // x forward, y left, z up becomes z forward, x left, y up
  turn << Vector3d::UnitY().transpose(), Vector3d::UnitZ().transpose(), Vector3d::UnitX().transpose();
  return turn;
}

// Arms at an angle from straight down, everything else as in the bind pose.
std::array<Matrix3d, kJoints> resting(const Skeleton& skeleton, const Matrix3d& file_from_world, double arms_deg) {
  std::array<Matrix3d, kJoints> frames;
  frames.fill(file_from_world);
  const double lift = arms_deg * std::numbers::pi / 180.0 - skeleton.arm_angle;
  for (const Side side : {Side::left, Side::right})
    for (const Joint left : {Joint::upper_arm_left, Joint::forearm_left, Joint::hand_left})
      frames[index(on_side(left, side))] = file_from_world * AngleAxisd(sign_of(side) * lift, Vector3d::UnitX());
  return frames;
}

std::string name_in(const Convention& convention, Joint joint) {
  for (const Side side : {Side::left, Side::right})
    for (const auto& [left, name] : convention.names) {
      std::string own = name;
      if (left >= Joint::clavicle_left && on_side(left, side) != joint) continue;
      if (left < Joint::clavicle_left && left != joint) continue;
      if (const auto at = own.find("Left"); side == Side::right && at != std::string::npos) own.replace(at, 4, "Right");
      if (const auto at = own.find("_l"); side == Side::right && at + 2 == own.size()) own.replace(at, 2, "_r");
      return own;
    }
  return {};
}

recon::BvhMotion written(const Skeleton& skeleton, const Motion& motion, const Convention& convention) {
  recon::BvhMotion bvh;
  std::vector<std::size_t> ours;
  std::array<int, kJoints> place;
  place.fill(-1);
  const auto named_parent = [&](std::size_t j) {
    auto above = index(parent_of(static_cast<Joint>(j)));
    while (place[above] < 0 && above != 0) above = index(parent_of(static_cast<Joint>(above)));
    return above;
  };
  for (std::size_t j = 0; j < kJoints; ++j) {
    const auto name = name_in(convention, static_cast<Joint>(j));
    if (name.empty()) continue;
    recon::BvhJoint joint;
    joint.name = name;
    if (j > 0) joint.parent = place[named_parent(j)];
    if (j > 0)
      joint.offset = convention.unit * (convention.file_from_bind[named_parent(j)] *
                                        (skeleton.joint[j] - skeleton.joint[named_parent(j)]));
    if (j == 0 || convention.positions_everywhere)
      joint.channels = {BvhChannel::x_position, BvhChannel::y_position, BvhChannel::z_position};
    for (const int axis : convention.order) joint.channels.push_back(static_cast<BvhChannel>(3 + axis));
    place[j] = static_cast<int>(bvh.joints.size());
    bvh.joints.push_back(joint);
    ours.push_back(j);
  }
  bvh.frame_time = kActStep;
  bvh.frames = static_cast<std::size_t>(motion.frames) + 1;
  for (std::size_t frame = 0; frame < bvh.frames; ++frame) {
    const Pose pose = motion.pose_at(static_cast<double>(frame) * kActStep);
    const auto turns = joint_transforms(skeleton, pose);
    const auto in_file = [&](std::size_t j) -> Matrix3d {
      return convention.file_from_world * turns[j].linear() * convention.file_from_bind[j].transpose();
    };
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const std::size_t j = ours[i];
      const Vector3d position =
          j == 0 ? Vector3d(convention.unit * (convention.file_from_world * pose.pelvis)) : bvh.joints[i].offset;
      if (bvh.joints[i].channels.size() == 6) bvh.values.insert(bvh.values.end(), position.begin(), position.end());
      const Matrix3d own = j == 0 ? in_file(j) : Matrix3d(in_file(named_parent(j)).transpose() * in_file(j));
      const Vector3d angles = own.eulerAngles(convention.order[0], convention.order[1], convention.order[2]);
      for (const double angle : angles) bvh.values.push_back(angle * 180.0 / std::numbers::pi);
    }
  }
  return bvh;
}

const std::map<Joint, std::string> kMotionBuilder = {{Joint::pelvis, "Hips"},
                                                     {Joint::spine, "Spine"},
                                                     {Joint::chest, "Spine1"},
                                                     {Joint::neck, "Neck"},
                                                     {Joint::head, "Head"},
                                                     {Joint::clavicle_left, "LeftShoulder"},
                                                     {Joint::upper_arm_left, "LeftArm"},
                                                     {Joint::forearm_left, "LeftForeArm"},
                                                     {Joint::hand_left, "LeftHand"},
                                                     {Joint::thigh_left, "LeftUpLeg"},
                                                     {Joint::shank_left, "LeftLeg"},
                                                     {Joint::foot_left, "LeftFoot"},
                                                     {Joint::toes_left, "LeftToeBase"}};
const std::map<Joint, std::string> kBiovision = {{Joint::pelvis, "Hips"},
                                                 {Joint::spine, "Chest"},
                                                 {Joint::chest, "Chest2"},
                                                 {Joint::neck, "Neck"},
                                                 {Joint::head, "Head"},
                                                 {Joint::clavicle_left, "LeftCollar"},
                                                 {Joint::upper_arm_left, "LeftShoulder"},
                                                 {Joint::forearm_left, "LeftElbow"},
                                                 {Joint::hand_left, "LeftWrist"},
                                                 {Joint::thigh_left, "LeftHip"},
                                                 {Joint::shank_left, "LeftKnee"},
                                                 {Joint::foot_left, "LeftAnkle"},
                                                 {Joint::toes_left, "LeftToe"}};
const std::map<Joint, std::string> kUnreal = {{Joint::pelvis, "pelvis"},
                                              {Joint::spine, "spine_01"},
                                              {Joint::chest, "spine_02"},
                                              {Joint::neck, "neck_01"},
                                              {Joint::head, "head"},
                                              {Joint::clavicle_left, "clavicle_l"},
                                              {Joint::upper_arm_left, "upperarm_l"},
                                              {Joint::forearm_left, "lowerarm_l"},
                                              {Joint::hand_left, "hand_l"},
                                              {Joint::thigh_left, "thigh_l"},
                                              {Joint::shank_left, "calf_l"},
                                              {Joint::foot_left, "foot_l"},
                                              {Joint::toes_left, "ball_l"}};

double degrees_apart(const Matrix3d& a, const Matrix3d& b) {
  return AngleAxisd(Matrix3d(a.transpose() * b)).angle() * 180.0 / std::numbers::pi;
}

class BvhMotionTest : public testing::Test {
 protected:
  Skeleton skeleton = make_skeleton(1.75);
  Motion walk = motion_of("walk", skeleton);

  // Largest difference of a joint's orientation in world over the walk, degrees.
  double apart(const Motion& found, Joint joint) const {
    double most = 0.0;
    for (int frame = 0; frame <= walk.frames; ++frame) {
      const double t = frame * kActStep;
      const auto wanted = joint_transforms(skeleton, walk.pose_at(t)),
                 seen = joint_transforms(skeleton, found.pose_at(t));
      most = std::max(most, degrees_apart(wanted[index(joint)].linear(), seen[index(joint)].linear()));
    }
    return most;
  }
  void expect_the_walk(const Motion& found) const {
    EXPECT_EQ(found.frames, walk.frames);
    EXPECT_TRUE(found.is_cyclic);
    const Vector3d off = found.pose_at(0.0).pelvis - walk.pose_at(0.0).pelvis;
    EXPECT_LT(std::abs(off.z()), 0.004);  // the floor is found by the soles alone
    for (int frame = 0; frame <= walk.frames; ++frame)
      EXPECT_LT((found.pose_at(frame * kActStep).pelvis - walk.pose_at(frame * kActStep).pelvis - off).norm(), 0.001);
  }
  // To an act frame.
  void expect_its_strikes(const Motion& found) const {
    const double round = walk.frames * kActStep;
    EXPECT_EQ(found.heel_strikes.size(), walk.heel_strikes.size());
    for (const auto& strike : walk.heel_strikes)
      EXPECT_TRUE(std::any_of(found.heel_strikes.begin(), found.heel_strikes.end(),
                              [&](const HeelStrike& seen) {
                                return seen.side == strike.side &&
                                       std::abs(std::remainder(seen.seconds - strike.seconds, round)) <= kActStep;
                              }))
          << strike.seconds << " s of " << round << ", found "
          << (found.heel_strikes.empty() ? -1.0 : found.heel_strikes.front().seconds);
  }
};

TEST_F(BvhMotionTest, ComesBackFromEveryConvention) {
  std::map<Joint, std::string> own;
  for (std::size_t j = 0; j < kJoints; ++j)
    if (const auto joint = static_cast<Joint>(j);
        !is_finger(joint) && to_string(joint).find("_right") == std::string_view::npos)
      own[joint] = to_string(joint);
  for (auto& [joint, name] : own)
    if (const auto at = name.find("_left"); at != std::string::npos) name.replace(at, 5, "_Left");
  const std::vector<Convention> conventions = {
      {own, y_up(), 100.0, {2, 0, 1}, false, resting(skeleton, y_up(), 45.0)},
      {kMotionBuilder, Matrix3d::Identity(), 1.0, {0, 1, 2}, true, resting(skeleton, Matrix3d::Identity(), 90.0)},
      {kBiovision, y_up(), 39.3701, {2, 1, 0}, false, resting(skeleton, y_up(), 0.0)},
      {kUnreal, y_up(), 1000.0, {1, 0, 2}, false, resting(skeleton, y_up(), 90.0)}};
  const std::vector<std::string> units = {"in centimetres", "in metres", "in inches", "in millimetres"};
  for (std::size_t i = 0; i < conventions.size(); ++i) {
    SCOPED_TRACE(units[i]);
    const auto bvh = recon::parse_bvh(recon::bvh_text(written(skeleton, walk, conventions[i])));
    const auto imported = import_motion(bvh, "walk.bvh", skeleton);
    EXPECT_THAT(imported.notes, Contains(HasSubstr(units[i])));
    EXPECT_THAT(imported.notes,
                Contains(HasSubstr(i == 1 ? "z is up; its zero pose stands" : "y is up; its zero pose stands")));
    expect_the_walk(imported.motion);
    expect_its_strikes(imported.motion);
    for (std::size_t j = 0; j < kJoints; ++j) {
      const auto joint = static_cast<Joint>(j);
      if (is_finger(joint)) continue;
      EXPECT_LT(apart(imported.motion, joint), 0.5) << to_string(joint);
    }
  }
}

// Blender's Rigify calls everything from hips to head spine.
TEST_F(BvhMotionTest, FindsPelvisAndHeadAmongBonesThatAreAllCalledSpine) {
  const std::map<Joint, std::string> rigify = {{Joint::pelvis, "spine"},
                                               {Joint::spine, "spine.001"},
                                               {Joint::chest, "spine.003"},
                                               {Joint::neck, "spine.004"},
                                               {Joint::head, "spine.006"},
                                               {Joint::clavicle_left, "shoulder.Left"},
                                               {Joint::upper_arm_left, "upper_arm.Left"},
                                               {Joint::forearm_left, "forearm.Left"},
                                               {Joint::hand_left, "hand.Left"},
                                               {Joint::thigh_left, "thigh.Left"},
                                               {Joint::shank_left, "shin.Left"},
                                               {Joint::foot_left, "foot.Left"},
                                               {Joint::toes_left, "toe.Left"}};
  const auto bvh = written(skeleton, walk, {rigify, y_up(), 1.0, {0, 1, 2}, false, resting(skeleton, y_up(), 45.0)});
  const auto imported = import_motion(bvh, "walk.bvh", skeleton);
  expect_the_walk(imported.motion);
  for (const Joint joint : {Joint::pelvis, Joint::chest, Joint::neck, Joint::head})
    EXPECT_LT(apart(imported.motion, joint), 0.5) << to_string(joint);
}

TEST_F(BvhMotionTest, TellsWhatItCannotUse) {
  auto names = kMotionBuilder;
  names.erase(Joint::clavicle_left);
  names[Joint::toes_left] = "Flipper_l";
  const auto imported =
      import_motion(written(skeleton, walk, {names, y_up(), 100.0, {2, 0, 1}, false, resting(skeleton, y_up(), 90.0)}),
                    "walk.bvh", skeleton);
  EXPECT_THAT(imported.notes, Contains(HasSubstr("not used: Flipper_l, Flipper_r")));
  EXPECT_THAT(imported.notes,
              Contains(HasSubstr("no counterpart, kept still: clavicle_left, clavicle_right, toes_left")));
  names[Joint::thigh_left] = "Stilt_l";
  try {
    import_motion(written(skeleton, walk, {names, y_up(), 100.0, {2, 0, 1}, false, resting(skeleton, y_up(), 90.0)}),
                  "walk.bvh", skeleton);
    FAIL() << "taken";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("walk.bvh: none of its joints is named like the thigh_left; they are: Hips"));
  }
}

TEST(JointNames, KnowsWhatPeopleCallThem) {
  using recon::Side;
  const auto segment = [](const std::vector<std::string>& names, std::size_t j) {
    const auto named = recon::name_joints(names, std::vector<int>(names.size(), -1));
    return named[j]
               ? static_cast<int>(named[j]->segment) * 10 + (named[j]->side ? 1 + static_cast<int>(*named[j]->side) : 0)
               : -1;
  };
  const auto is = [](BodySegment wanted, std::optional<Side> side = std::nullopt) {
    return static_cast<int>(wanted) * 10 + (side ? 1 + static_cast<int>(*side) : 0);
  };
  EXPECT_EQ(segment({"J_Bip_L_UpperLeg"}, 0), is(BodySegment::thigh, Side::left));
  EXPECT_EQ(segment({"Bip01 R Thigh"}, 0), is(BodySegment::thigh, Side::right));
  EXPECT_EQ(segment({"Shoulder_L", "UpperArm_L"}, 0), is(BodySegment::clavicle, Side::left));
  EXPECT_EQ(segment({"LeftCollar", "LeftShoulder"}, 1), is(BodySegment::upper_arm, Side::left));
  EXPECT_EQ(segment({"LHipJoint", "LeftUpLeg", "LeftLeg"}, 0), -1);
  EXPECT_EQ(segment({"LHipJoint", "LeftUpLeg", "LeftLeg"}, 2), is(BodySegment::shank, Side::left));
  EXPECT_EQ(segment({"rShldr", "rForeArm"}, 0), is(BodySegment::upper_arm, Side::right));
  EXPECT_EQ(segment({"R_Ankle", "R_Foot"}, 1), is(BodySegment::toes, Side::right));
  EXPECT_EQ(segment({"LeftHandIndex1"}, 0), -1);
  EXPECT_EQ(segment({"lthigh"}, 0), is(BodySegment::thigh, Side::left));
  EXPECT_EQ(segment({"lfemur"}, 0), is(BodySegment::thigh, Side::left));
  EXPECT_EQ(segment({"rhumerus", "rradius"}, 1), is(BodySegment::forearm, Side::right));
  EXPECT_EQ(segment({"HipLeft", "KneeLeft"}, 0), is(BodySegment::thigh, Side::left));
  EXPECT_EQ(segment({"LUArm", "LFArm"}, 0), is(BodySegment::upper_arm, Side::left));
}

}  // namespace
}  // namespace rotunda::simulator
