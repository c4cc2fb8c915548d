#include "recon/body/body_template.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(BodyTemplate, IsSixteenClosedSegmentsAsTallAsAskedWithTheVolumeOfAPerson) {
  const auto body = template_of_height(1.75);
  EXPECT_NEAR(height_of(body.measures), 1.75, 1e-9);
  const auto mesh = pose_template(body, rest_pose());
  const auto topology = topology_of(mesh);
  EXPECT_EQ(topology.components, kBodySegments);
  EXPECT_TRUE(topology.manifold);
  EXPECT_EQ(topology.euler_characteristic, 2 * static_cast<long>(kBodySegments));
  EXPECT_EQ(triangle_segments().size(), mesh.triangles.size());
  EXPECT_NEAR(signed_volume(mesh), 0.080, 0.015);  // 75 kg at 1 kg/l, joints counted twice
  float low = 10.0F, high = -10.0F;
  for (const auto& p : mesh.positions) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  EXPECT_NEAR(high - low, 1.75, 0.01);
}

TEST(BodyTemplate, IsTheSameOnBothSides) {
  const auto body = template_of_height(1.6);
  for (const auto& [left, right] : {std::pair<std::size_t, std::size_t>{4, 7}, {6, 9}, {10, 13}, {12, 15}})
    for (const auto& vertex : body.segments[left].vertices) {
      const Vector3d mirror(vertex.x(), -vertex.y(), vertex.z());
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& other : body.segments[right].vertices) nearest = std::min(nearest, (other - mirror).norm());
      EXPECT_LT(nearest, 1e-12);
    }
}

TEST(BodyTemplate, RefusesAMeasureThatIsNoLength) {
  auto measures = measures_of_height(1.75);
  measures[index(BodyMeasure::shank)] = -0.1;
  EXPECT_THROW(make_template(measures), InvalidInput);
}

TEST(Pose, ElbowAndKneeBendTheWayPeopleDo) {
  const auto skeleton = template_of_height(1.75).skeleton;
  auto pose = rest_pose();
  const auto bend = [&](BodyJoint joint) {
    const auto& range = range_of(joint);
    pose.rotation[index(joint)] = Quaterniond(AngleAxisd(0.5 * std::numbers::pi, range.hinge));
    const auto coordinates = range_coordinates(range, pose.rotation[index(joint)]);
    EXPECT_TRUE((coordinates.array() <= range.high.array() + 1e-9).all());
    EXPECT_TRUE((coordinates.array() >= range.low.array() - 1e-9).all());
  };
  for (const auto joint :
       {BodyJoint::forearm_left, BodyJoint::forearm_right, BodyJoint::shank_left, BodyJoint::shank_right})
    bend(joint);
  const auto at = joint_positions(skeleton, pose);
  for (const auto hand : {BodyJoint::hand_left, BodyJoint::hand_right}) EXPECT_GT(at[index(hand)].x(), 0.2);
  for (const auto foot : {BodyJoint::foot_left, BodyJoint::foot_right}) EXPECT_LT(at[index(foot)].x(), -0.35);
}

TEST(Pose, CoordinatesOfARotationLeadBackToIt) {
  for (std::size_t j = 1; j < kBodyJoints; ++j) {
    const auto& range = range_of(body_joint(j));
    const Vector3d inside = range.low + 0.3 * (range.high - range.low);
    const auto rotation = rotation_at(range, inside);
    EXPECT_LT((range_coordinates(range, rotation) - inside).norm(), 1e-9) << to_string(body_joint(j));
  }
}

TEST(Pose, AMirroredPoseStandsMirrored) {
  const auto skeleton = template_of_height(1.75).skeleton;
  auto pose = rest_pose();
  pose.rotation[index(BodyJoint::upper_arm_left)] = AngleAxisd(-0.8, Vector3d(1, 0.2, 0.4).normalized());
  pose.rotation[index(BodyJoint::thigh_right)] = AngleAxisd(0.7, Vector3d(0.2, 1, 0.3).normalized());
  const auto at = joint_positions(skeleton, pose), other = joint_positions(skeleton, mirrored(pose));
  for (std::size_t j = 0; j < kBodyJoints; ++j)
    EXPECT_LT((at[j].cwiseProduct(Vector3d(1, -1, 1)) - other[index(mirrored(body_joint(j)))]).norm(), 1e-12);
  pose.rotation[index(BodyJoint::shank_right)] = AngleAxisd(-1.0, Vector3d::UnitY());  // a knee the wrong way
  const auto limited = within_limits(pose);
  EXPECT_LT(limited.rotation[index(BodyJoint::shank_right)].angularDistance(Quaterniond::Identity()), 0.2);
}

}  // namespace
}  // namespace rotunda::recon
