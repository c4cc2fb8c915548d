#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <optional>

#include "simulator/people/act.h"
#include "simulator/people/keyed_motion.h"

namespace rotunda::simulator {
namespace {

const Skeleton& somebody() {
  static const Skeleton bones = make_skeleton(1.75);
  return bones;
}

// What of both soles (and of palms near the floor) carries: heel, ball, tip and their breadth, from above.
std::vector<cv::Point2f> support_of(const JointTransforms& joints) {
  constexpr double kDown = 0.010, kBreadth = 0.040;
  std::vector<cv::Point2f> support;
  const auto add = [&](const Eigen::Vector3d& at) {
    support.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()));
  };
  for (const Side side : {Side::left, Side::right}) {
    const Joint foot = on_side(Joint::foot_left, side), toes = on_side(Joint::toes_left, side);
    const Eigen::Vector3d ankle = somebody().joint[index(foot)], ball = somebody().joint[index(toes)];
    const std::array<std::pair<Joint, Eigen::Vector3d>, 3> points = {{{foot, {ankle.x() - 0.06, ankle.y(), 0.0}},
                                                                      {toes, {ball.x(), ball.y(), 0.0}},
                                                                      {toes, {ball.x() + 0.06, ball.y(), 0.0}}}};
    for (const auto& [joint, point] : points)
      for (const double across : {-kBreadth, kBreadth}) {
        const Eigen::Vector3d at = joints[index(joint)] * (point + Eigen::Vector3d(0.0, across, 0.0));
        if (at.z() < kDown) add(at);
      }
    const Eigen::Vector3d wrist =
        joints[index(on_side(Joint::hand_left, side))] * somebody().joint[index(on_side(Joint::hand_left, side))];
    if (wrist.z() < 0.12) add(wrist);
  }
  return support;
}

// How far the centre of mass is inside what carries it, seen from above; negative: outside. None in flight.
std::optional<double> balance_of(const Pose& pose) {
  std::vector<cv::Point2f> hull;
  const auto support = support_of(joint_transforms(somebody(), pose));
  if (support.size() < 3) return std::nullopt;
  cv::convexHull(support, hull);
  const Eigen::Vector3d centre = centre_of_mass(somebody(), pose);
  return cv::pointPolygonTest(hull, {static_cast<float>(centre.x()), static_cast<float>(centre.y())}, true);
}

double least_balance(const Motion& motion, double from, double until) {
  double least = 1.0;
  for (double t = from; t <= until; t += 0.04)
    if (const auto balance = balance_of(motion.pose_at(t))) least = std::min(least, *balance);
  return least;
}

TEST(Balance, WhoStandsStillHasTheWeightWellOverTheFeet) {
  for (const auto* name : {"idle", "hands-on-hips"}) {
    const auto motion = motion_of(name, somebody());
    EXPECT_GT(least_balance(motion, 0.0, motion.frames * kActStep), 0.03) << name;
  }
  for (const auto* name : {"kick", "turn", "capoeira", "dance", "board", "idle-walk"})
    EXPECT_GT(least_balance(motion_of(name, somebody()), 0.0, 0.04), 0.03) << name << " begins in a stand";
  for (const auto* name : {"kick", "turn", "capoeira", "dance", "board", "walk-idle"}) {
    const auto motion = motion_of(name, somebody());
    const double end = motion.frames * kActStep;
    EXPECT_GT(least_balance(motion, end - 0.04, end), 0.03) << name << " ends in a stand";
  }
}

// Who moves on the spot may leave the support by what a step catches; who walks falls from foot to foot: at most half a
// step (Winter 1995, Human balance and posture control during standing and walking).
TEST(Balance, WhoMovesIsNeverFurtherFromTheFeetThanAStepCatches) {
  for (const auto& [name, most] : {std::pair{"kick", 0.10},
                                   {"turn", 0.10},
                                   {"capoeira", 0.20},
                                   {"dance", 0.26},
                                   {"board", 0.20},
                                   {"walk", 0.25},
                                   {"jog", 0.30},
                                   {"idle-walk", 0.25},
                                   {"walk-idle", 0.25},
                                   {"walk-jog", 0.30},
                                   {"jog-walk", 0.30}}) {
    const auto motion = motion_of(name, somebody(), {.travel = true});
    EXPECT_GT(least_balance(motion, 0.0, motion.frames * kActStep), -most) << name;
  }
}

}  // namespace
}  // namespace rotunda::simulator
