#include "simulator/people/gait.h"

#include <gtest/gtest.h>

#include <numbers>

#include "config/errors.h"
#include "simulator/people/act.h"
#include "simulator/people/limb_pose.h"

namespace rotunda::simulator {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

const Skeleton& skeleton() {
  static const Skeleton bones = make_skeleton(1.75);
  return bones;
}

Eigen::Vector3d joint_at(Joint joint, double seconds) {
  return joint_centres(skeleton(), gait_pose(skeleton(), seconds))[index(joint)];
}

TEST(Gait, ClosesExactlyAfterOnePeriod) {
  const auto start = joint_centres(skeleton(), gait_pose(skeleton(), 0.0));
  const auto end = joint_centres(skeleton(), gait_pose(skeleton(), GaitOptions{}.period));
  for (std::size_t j = 0; j < kJoints; ++j) EXPECT_LT((start[j] - end[j]).norm(), 1e-9);
}

TEST(Gait, APeriodIsWholeActFrames) {
  EXPECT_DOUBLE_EQ(GaitOptions{}.period, motion_of("walk", skeleton()).frames * kActStep);
}

TEST(Gait, LimbsKeepTheirLengths) {
  for (double t = 0.0; t < 1.04; t += 0.01)
    EXPECT_NEAR((joint_at(Joint::shank_left, t) - joint_at(Joint::foot_left, t)).norm(), skeleton().shank_length(),
                1e-9);
}

// From flat foot to heel off the ball of the foot lies on the floor and goes back with it.
TEST(Gait, TheStanceFootDoesNotSlideOnTheBelt) {
  const GaitOptions gait;
  const double from = 0.11 * gait.period, to = 0.60 * gait.period;
  const Eigen::Vector3d first = joint_at(Joint::toes_left, from);
  for (double t = from; t < to; t += 0.01) {
    const Eigen::Vector3d now = joint_at(Joint::toes_left, t) + Eigen::Vector3d(gait.speed * (t - from), 0.0, 0.0);
    EXPECT_LT((now - first).norm(), 0.003) << "at " << t << " s";
  }
}

TEST(Gait, RightIsLeftHalfAPeriodLater) {
  for (double t = 0.0; t < 1.0; t += 0.07) {
    const Eigen::Vector3d left = joint_at(Joint::foot_left, t), right = joint_at(Joint::foot_right, t + 0.52);
    EXPECT_LT((left - Eigen::Vector3d(right.x(), -right.y(), right.z())).norm(), 1e-9);
  }
}

TEST(Gait, TheHeelComesDownAtItsStrike) {
  const auto strikes = heel_strikes();
  ASSERT_EQ(strikes.size(), 2U);
  for (const auto& strike : strikes) {
    const Joint foot = on_side(Joint::foot_left, strike.side), toes = on_side(Joint::toes_left, strike.side);
    EXPECT_GT(joint_at(foot, strike.seconds - 0.03).z(), joint_at(foot, strike.seconds).z());
    EXPECT_GT(joint_at(toes, strike.seconds).z(), skeleton().joint[index(toes)].z() + 0.02);  // toes still up
  }
}

TEST(Gait, TheKneeFollowsTheNormalCurve) {
  double squares = 0.0;
  constexpr int kSamples = 104;
  for (int i = 0; i < kSamples; ++i) {
    const double phase = static_cast<double>(i) / kSamples;
    const double knee = knee_flexion(gait_pose(skeleton(), phase * GaitOptions{}.period), Side::left);
    squares += std::pow(knee - normal_leg_angles(phase).knee, 2) / kSamples;
  }
  EXPECT_LT(std::sqrt(squares), 15.0 * kDegree);  // one standard deviation of normal subjects is 6 to 8 degrees
}

// Bones as cylinders with the clothes' radii: arms never touch the trunk, shanks never each other.
TEST(Gait, LimbsClearTheBodyAndEachOther) {
  for (double t = 0.0; t < 1.04; t += 0.02) {
    const auto joints = joint_centres(skeleton(), gait_pose(skeleton(), t));
    const auto at = [&](Joint joint) { return joints[index(joint)]; };
    EXPECT_GT(at(Joint::hand_left).y(), 0.178 + 0.030 + 0.02) << t;  // hips, half a wrist, 2 cm of air
    EXPECT_LT(at(Joint::hand_right).y(), -0.228) << t;
    EXPECT_GT(at(Joint::foot_left).y() - at(Joint::foot_right).y(), 2 * 0.064 + 0.02) << t;
  }
}

TEST(Act, AnUnknownActIsToldWithTheKnownOnes) {
  try {
    motion_of("fly", skeleton());
    FAIL() << "there is no such act";
  } catch (const InvalidInput& error) {
    for (const auto& name : act_names()) EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
  }
}

TEST(Act, ACyclicActRepeatsAfterItsFrames) {
  for (const auto& name : act_names()) {
    const auto motion = motion_of(name, skeleton());
    if (!motion.is_cyclic) continue;
    const auto a = joint_centres(skeleton(), motion.pose_at(0.0));
    const auto b = joint_centres(skeleton(), motion.pose_at(motion.frames * kActStep));
    for (std::size_t j = 0; j < kJoints; ++j) EXPECT_LT((a[j] - b[j]).norm(), 1e-9) << name;
  }
}

}  // namespace
}  // namespace rotunda::simulator
