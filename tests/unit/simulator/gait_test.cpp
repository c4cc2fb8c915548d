#include "simulator/people/gait.h"

#include <gtest/gtest.h>

#include <numbers>

#include "simulator/people/act.h"

namespace rotunda::simulator {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

const Skeleton& skeleton() {
  static const Skeleton bones = make_skeleton(1.75);
  return bones;
}

const Motion& motion(const GaitStyle& style) {
  static const Motion walk = motion_of("walk", skeleton()), jog = motion_of("jog", skeleton());
  return &style == &walking() ? walk : jog;
}

Eigen::Vector3d joint_at(const GaitStyle& style, Joint joint, double seconds) {
  return joint_centres(skeleton(), motion(style).pose_at(seconds))[index(joint)];
}

TEST(Gait, APeriodIsWholeActFrames) {
  for (const auto* style : {&walking(), &jogging()}) EXPECT_DOUBLE_EQ(style->period, motion(*style).frames * kActStep);
}

TEST(Gait, RightIsLeftHalfAPeriodLater) {
  for (const auto* style : {&walking(), &jogging()})
    for (double t = 0.0; t < 0.5 * style->period; t += 0.03) {
      const auto left = joint_at(*style, Joint::foot_left, t);
      const auto right = joint_at(*style, Joint::foot_right, t + 0.5 * style->period);
      EXPECT_LT((left - Eigen::Vector3d(right.x(), -right.y(), right.z())).norm(), 1e-6);
    }
}

TEST(Gait, TheHeelComesDownAtItsStrike) {
  for (const auto* style : {&walking(), &jogging()}) {
    const auto& strikes = motion(*style).heel_strikes;
    ASSERT_EQ(strikes.size(), 2U);
    for (const auto& strike : strikes) {
      const Joint foot = on_side(Joint::foot_left, strike.side), toes = on_side(Joint::toes_left, strike.side);
      const double before = strike.seconds > 0.0 ? strike.seconds - 0.02 : style->period - 0.02;
      EXPECT_GT(joint_at(*style, foot, before).z(), joint_at(*style, foot, strike.seconds).z());
      EXPECT_GT(joint_at(*style, toes, strike.seconds).z(), skeleton().joint[index(toes)].z() + 0.005);  // still up
    }
  }
}

TEST(Gait, TheKneeFollowsTheNormalCurve) {
  for (const auto* style : {&walking(), &jogging()}) {
    double squares = 0.0;
    constexpr int kSamples = 104;
    for (int i = 0; i < kSamples; ++i) {
      const double phase = static_cast<double>(i) / kSamples;
      const double knee = knee_flexion(skeleton(), motion(*style).pose_at(phase * style->period), Side::left);
      squares += std::pow(knee - sagittal_angles(*style, phase).knee, 2) / kSamples;
    }
    EXPECT_LT(std::sqrt(squares), 15.0 * kDegree);  // one standard deviation of normal subjects is 6 to 8 degrees
  }
}

TEST(Gait, AJoggerFliesTwiceAStrideAndAWalkerNever) {
  for (const auto* style : {&walking(), &jogging()}) {
    int flying = 0;
    for (double t = 0.0; t < style->period; t += 0.005) {
      const auto rest = skeleton().joint[index(Joint::toes_left)].z() + 0.004;
      const bool left = joint_at(*style, Joint::toes_left, t).z() < rest;
      const bool right = joint_at(*style, Joint::toes_right, t).z() < rest;
      const bool heels = std::min(joint_at(*style, Joint::foot_left, t).z(),
                                  joint_at(*style, Joint::foot_right, t).z()) < ankle_height(skeleton()) + 0.012;
      if (!left && !right && !heels) ++flying;
    }
    if (style == &walking())
      EXPECT_EQ(flying, 0);
    else
      EXPECT_GT(flying * 0.005, 0.05);  // Novacheck 1998: two flights of a tenth of the stride each
  }
}

TEST(Gait, ARampsIntegralIsTheAreaUnderIt) {
  const Ramp ramp{.from = 1.0, .to = 3.0, .start = 0.5, .end = 1.5};
  double sum = 0.0;
  constexpr double kStep = 1e-4;
  for (double t = 0.0; t < 2.0; t += kStep) sum += kStep * ramp.at(t + 0.5 * kStep);
  EXPECT_NEAR(ramp.integral(2.0), sum, 1e-3);
}

// Bones as cylinders with the clothes' radii: arms never touch the trunk, shanks never each other.
TEST(Gait, LimbsClearTheBodyAndEachOther) {
  for (double t = 0.0; t < 1.04; t += 0.02) {
    const auto joints = joint_centres(skeleton(), motion(walking()).pose_at(t));
    const auto at = [&](Joint joint) { return joints[index(joint)]; };
    EXPECT_GT(at(Joint::hand_left).y(), 0.178 + 0.030 + 0.02) << t;  // hips, half a wrist, 2 cm of air
    EXPECT_LT(at(Joint::hand_right).y(), -0.228) << t;
    EXPECT_GT(at(Joint::foot_left).y() - at(Joint::foot_right).y(), 2 * 0.064 + 0.02) << t;
  }
}

}  // namespace
}  // namespace rotunda::simulator
