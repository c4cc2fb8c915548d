#include "simulator/people/skeleton.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace rotunda::simulator {
namespace {

TEST(Skeleton, EveryJointHasANameOfItsOwnAndAParentBeforeIt) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto joint = static_cast<Joint>(i);
    EXPECT_TRUE(names.insert(to_string(joint)).second) << to_string(joint);
    EXPECT_TRUE(joint == Joint::pelvis || index(parent_of(joint)) < i) << to_string(joint);
  }
}

TEST(Skeleton, RightIsTheMirrorOfLeft) {
  const auto skeleton = make_skeleton(1.75);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::string name(to_string(static_cast<Joint>(i)));
    if (name.size() < 5 || name.substr(name.size() - 5) != "_left") continue;
    const Joint right = on_side(static_cast<Joint>(i), Side::right);
    EXPECT_EQ(to_string(right), name.substr(0, name.size() - 4) + "right");
    const Eigen::Vector3d mirrored = skeleton.joint[index(right)].cwiseProduct(Eigen::Vector3d(1, -1, 1));
    EXPECT_LT((mirrored - skeleton.joint[i]).norm(), 1e-12) << name;
    EXPECT_EQ(on_side(static_cast<Joint>(i), Side::left), static_cast<Joint>(i));
  }
}

// The palm faces the body: a fist brings the fingers' next joints nearer to it than the stretched hand.
TEST(Skeleton, AFistClosesTowardsThePalm) {
  const auto skeleton = make_skeleton(1.75);
  for (const Side side : {Side::left, Side::right}) {
    auto pose = bind_pose(skeleton);
    curl_fingers(pose, side, 4.0);
    const auto open = joint_centres(skeleton, bind_pose(skeleton)), closed = joint_centres(skeleton, pose);
    for (const Joint left : {Joint::index2_left, Joint::middle2_left, Joint::ring2_left, Joint::little2_left}) {
      const auto i = index(on_side(left, side));
      EXPECT_LT(std::abs(closed[i].y()), std::abs(open[i].y()) - 0.03);
      EXPECT_NEAR((closed[i] - closed[i - 1]).norm(), (open[i] - open[i - 1]).norm(), 1e-9);
    }
  }
}

}  // namespace
}  // namespace rotunda::simulator
