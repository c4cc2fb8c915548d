#include "simulator/people/act.h"

#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "config/errors.h"
#include "simulator/people/gait.h"

namespace rotunda::simulator {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<Skeleton> people() {
  return {make_skeleton(1.58), make_skeleton(1.92)};
}

const Skeleton& somebody() {
  static const Skeleton bones = make_skeleton(1.75);
  return bones;
}

// How fast the floor runs back under one who walks on the spot.
double floor_speed(const std::string& act, const Skeleton& skeleton) {
  const double scale = leg_scale(skeleton);
  return act == "walk" ? scale * walking().speed : act == "jog" ? scale * jogging().speed : 0.0;
}

template <class Check>
void at_every_moment(const Motion& motion, const Skeleton& skeleton, double step, const Check& check) {
  const double end = motion.frames * kActStep;
  for (double t = 0.0; t <= end; t += step) {
    const Pose pose = motion.pose_at(t);
    check(t, pose, joint_transforms(skeleton, pose));
  }
}

TEST(Act, AnUnknownActIsToldWithTheKnownOnes) {
  try {
    motion_of("fly", somebody());
    FAIL() << "there is no such act";
  } catch (const InvalidInput& error) {
    for (const auto& name : act_names()) EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
  }
}

TEST(Act, ACyclicActRepeatsAfterItsFrames) {
  for (const auto& name : act_names()) {
    const auto motion = motion_of(name, somebody());
    if (!motion.is_cyclic) continue;
    const auto a = joint_centres(somebody(), motion.pose_at(0.0));
    const auto b = joint_centres(somebody(), motion.pose_at(motion.frames * kActStep));
    for (std::size_t j = 0; j < kJoints; ++j) EXPECT_LT((a[j] - b[j]).norm(), 1e-9) << name;
  }
}

// While the ball of a foot lies on the floor it stays where it is; coming down takes it 20 ms.
TEST(Act, StandingFeetDoNotSlide) {
  constexpr double kStep = 0.02, kTouches = 0.0006;
  for (const auto& skeleton : people())
    for (const auto& name : act_names()) {
      if (name == "a-pose") continue;
      const auto motion = motion_of(name, skeleton);
      for (const Joint ball : {Joint::toes_left, Joint::toes_right}) {
        const Eigen::Vector3d rest = skeleton.joint[index(ball)];
        std::optional<Eigen::Vector2d> stood;
        bool touched = false;
        at_every_moment(motion, skeleton, kStep, [&](double t, const Pose&, const JointTransforms& joints) {
          const Eigen::Vector3d now = joints[index(ball)] * rest;
          const Eigen::Vector2d on_floor(now.x() + floor_speed(name, skeleton) * t, now.y());
          if (now.z() > rest.z() + kTouches) {
            stood.reset();
            touched = false;
            return;
          }
          if (!std::exchange(touched, true)) return;
          if (!stood) stood = on_floor;
          EXPECT_LT((on_floor - *stood).norm(), 0.003) << name << " at " << t << " s";
        });
      }
    }
}

// Heel, ball and toe tip of the sole, none more than 3 mm under the floor.
TEST(Act, NoFootGoesThroughTheFloor) {
  for (const auto& skeleton : people())
    for (const auto& name : act_names()) {
      const double k = skeleton.height / 1.75;
      at_every_moment(motion_of(name, skeleton), skeleton, 0.04,
                      [&](double t, const Pose&, const JointTransforms& joints) {
                        for (const Side side : {Side::left, Side::right}) {
                          const Joint foot = on_side(Joint::foot_left, side), toes = on_side(Joint::toes_left, side);
                          const Eigen::Vector3d ankle = skeleton.joint[index(foot)], ball = skeleton.joint[index(toes)];
                          const Eigen::Vector3d heel = ankle + Eigen::Vector3d(-0.06 * k, 0.0, 0.006 * k - ankle.z());
                          const Eigen::Vector3d tip = ball + Eigen::Vector3d(0.06 * k, 0.0, 0.003 * k - ball.z());
                          EXPECT_GT((joints[index(foot)] * heel).z(), -0.003) << name << " heel at " << t;
                          EXPECT_GT((joints[index(toes)] * ball).z(), ball.z() - 0.003) << name << " ball at " << t;
                          EXPECT_GT((joints[index(toes)] * tip).z(), -0.003) << name << " toes at " << t;
                        }
                      });
    }
}

// Norkin and White, Measurement of Joint Motion, 2016: knee 0 to 150, elbow 0 to 150 degrees.
TEST(Act, KneesAndElbowsNeverBendBackwards) {
  for (const auto& skeleton : people())
    for (const auto& name : act_names())
      at_every_moment(motion_of(name, skeleton), skeleton, 0.04,
                      [&](double t, const Pose& pose, const JointTransforms&) {
                        for (const Side side : {Side::left, Side::right}) {
                          EXPECT_GE(knee_flexion(skeleton, pose, side), -1e-6) << name << " at " << t;
                          EXPECT_LE(knee_flexion(skeleton, pose, side), 150.0 * kDegree) << name << " at " << t;
                          EXPECT_GE(elbow_flexion(skeleton, pose, side), -1e-6) << name << " at " << t;
                          EXPECT_LE(elbow_flexion(skeleton, pose, side), 150.0 * kDegree) << name << " at " << t;
                        }
                      });
}

// Norkin and White 2016, rounded up: how far a joint may turn from the bind pose in all, degrees.
TEST(Act, JointsStayWithinTheirLimits) {
  const std::vector<std::pair<Joint, double>> limits = {
      {Joint::spine, 50},       {Joint::chest, 50},        {Joint::neck, 45},      {Joint::head, 50},
      {Joint::thigh_left, 140}, {Joint::thigh_right, 140}, {Joint::foot_left, 75}, {Joint::foot_right, 75},
      {Joint::hand_left, 110},  {Joint::hand_right, 110}};
  for (const auto& name : act_names())
    at_every_moment(
        motion_of(name, somebody()), somebody(), 0.04, [&](double t, const Pose& pose, const JointTransforms&) {
          for (const auto& [joint, limit] : limits)
            EXPECT_LT(pose.rotation[index(joint)].angularDistance(Eigen::Quaterniond::Identity()), limit * kDegree)
                << name << ": " << to_string(joint) << " at " << t;
        });
}

TEST(Act, NothingJumps) {
  constexpr double kStep = 0.01;
  for (const auto& name : act_names()) {
    const auto motion = motion_of(name, somebody());
    for (double t = kStep; t < motion.frames * kActStep; t += kStep) {
      const auto before = joint_centres(somebody(), motion.pose_at(t - kStep));
      const auto now = joint_centres(somebody(), motion.pose_at(t));
      for (std::size_t j = 0; j < kJoints; ++j)
        EXPECT_LT((now[j] - before[j]).norm(), 12.0 * kStep)  // a kicking foot is the fastest, about 10 m/s
            << name << ": " << to_string(static_cast<Joint>(j)) << " at " << t;
    }
  }
}

TEST(Act, EverybodyStaysInsideTheVolume) {
  for (const auto& skeleton : people())
    for (const auto& name : act_names())
      at_every_moment(motion_of(name, skeleton, {.travel = true}), skeleton, 0.04,
                      [&](double t, const Pose& pose, const JointTransforms&) {
                        EXPECT_LT(std::abs(pose.pelvis.x()), 1.5) << name << " at " << t;
                        EXPECT_LT(std::abs(pose.pelvis.y()), 1.0) << name << " at " << t;
                      });
}

// The pose at `a_seconds` of a is that at `b_seconds` of b, at another place, and goes on at the same speed.
void expect_joined(const Motion& a, double a_seconds, const Motion& b, double b_seconds, double b_floor) {
  constexpr double kStep = 0.002;
  const auto points = [](const Motion& motion, double t) {
    auto centres = joint_centres(somebody(), motion.pose_at(t));
    return centres;
  };
  const auto a0 = points(a, a_seconds), b0 = points(b, b_seconds);
  const Eigen::Vector3d moved(a0[0].x() - b0[0].x(), a0[0].y() - b0[0].y(), 0.0);
  const double inwards = a_seconds > 0.0 ? -kStep : kStep;  // a runs up to the joint, or on from it
  const double b_other = b_seconds + inwards < 0.0 ? b.frames * kActStep + inwards : b_seconds + inwards;
  const auto a1 = points(a, a_seconds + inwards), b1 = points(b, b_other);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_LT((a0[j] - b0[j] - moved).norm(), 1e-4) << a.name << ": " << to_string(static_cast<Joint>(j));
    const Eigen::Vector3d belt(b_floor * inwards, 0.0, 0.0);
    EXPECT_LT((a1[j] - b1[j] - belt - moved).norm(), 0.0003)  // 0.15 m/s
        << a.name << ": speed of " << to_string(static_cast<Joint>(j));
  }
}

TEST(Act, TransitionsStartAndEndInTheCyclesTheyJoin) {
  const auto of = [](const char* name) { return motion_of(name, somebody()); };
  const auto end = [](const Motion& motion) { return motion.frames * kActStep; };
  const Motion idle = of("idle"), walk = of("walk"), jog = of("jog");
  const double walked = floor_speed("walk", somebody()), jogged = floor_speed("jog", somebody());
  for (const auto& [name, from, from_speed, to, to_speed] :
       {std::tuple{"idle-walk", &idle, 0.0, &walk, walked}, std::tuple{"walk-idle", &walk, walked, &idle, 0.0},
        std::tuple{"walk-jog", &walk, walked, &jog, jogged}, std::tuple{"jog-walk", &jog, jogged, &walk, walked}}) {
    const Motion transition = of(name);
    expect_joined(transition, 0.0, *from, 0.0, from_speed);
    expect_joined(transition, end(transition), *to, 0.0, to_speed);
  }
}

TEST(Act, TheSeedDecidesTheSmallVariations) {
  const auto hand = [](std::uint32_t seed) {
    const auto motion = motion_of("idle", somebody(), {.seed = seed});
    return joint_centres(somebody(), motion.pose_at(1.0))[index(Joint::hand_left)];
  };
  EXPECT_EQ(hand(3), hand(3));
  EXPECT_GT((hand(3) - hand(4)).norm(), 0.001);
}

}  // namespace
}  // namespace rotunda::simulator
