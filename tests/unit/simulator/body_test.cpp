// Every person's body: its surface, hands and how it bends. Coarse surfaces where the claim does not need the fine one.
#include <gtest/gtest.h>

#include <numbers>

#include "simulator/people/body_mesh.h"
#include "simulator/people/person.h"

namespace rotunda::simulator {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

struct Body {
  Skeleton skeleton;
  recon::TriangleMesh bind;
  std::vector<SkinWeights> weights;
};

Body coarse_body(std::string_view name) {
  const auto build = describe_person(name).build;
  Body body{make_skeleton(build.height, build.proportions), {}, {}};
  const BodyShape shape(body.skeleton, build);
  body.bind = body_mesh(shape, body.skeleton, 1.5);
  body.weights = skin_weights(body.bind, shape);
  return body;
}

const Body& anna() {
  static const Body body = coarse_body("anna");
  return body;
}

recon::TriangleMesh posed(const Body& body, const Pose& pose) {
  return skinned(body.bind, body.weights, joint_transforms(body.skeleton, pose));
}

Pose turned(const Body& body, Joint left_joint, double degrees, const Eigen::Vector3d& axis) {
  Pose pose = bind_pose(body.skeleton);
  pose.rotation[index(left_joint)] = Eigen::AngleAxisd(degrees * kDegree, axis);
  return pose;
}

class EveryBody : public testing::TestWithParam<std::string> {};

TEST_P(EveryBody, IsOneClosedSurfaceWithoutAHandleOfTwentyToSixtyThousandTriangles) {
  const auto build = describe_person(GetParam()).build;
  const auto skeleton = make_skeleton(build.height, build.proportions);
  const auto mesh = body_mesh(BodyShape(skeleton, build), skeleton);
  EXPECT_TRUE(recon::topology_of(mesh).is_sphere());
  EXPECT_GE(mesh.triangles.size(), 20000U);
  EXPECT_LE(mesh.triangles.size(), 60000U);
  double high = 0.0;
  for (const auto& p : mesh.positions) high = std::max(high, static_cast<double>(p.z()));
  EXPECT_NEAR(high, build.height, 0.035);  // hair; heads vary less than heights
}

INSTANTIATE_TEST_SUITE_P(People, EveryBody, testing::ValuesIn(person_names()),
                         [](const auto& name) { return name.param; });

TEST(Bodies, DifferInHeightAndVolume) {
  const auto names = person_names();
  ASSERT_GE(names.size(), 4U);
  int women = 0;
  for (const auto& name : names) women += describe_person(name).build.sex == Sex::female ? 1 : 0;
  EXPECT_GE(women, 2);
}

// A line across the four fingers leaves and enters the hand again between them.
TEST(Bodies, TheFingersAreApart) {
  const auto build = describe_person("anna").build;
  const auto skeleton = make_skeleton(build.height, build.proportions);
  const BodyShape shape(skeleton, build);
  for (const Side side : {Side::left, Side::right}) {
    const auto at = [&](Joint left) { return skeleton.joint[index(on_side(left, side))]; };
    const Eigen::Vector3d from = at(Joint::index2_left), to = at(Joint::little2_left);
    int fingers = 0;
    bool inside = false;
    for (double t = -0.3; t < 1.3; t += 0.002) {
      const Eigen::Vector3d p = from + t * (to - from);
      const bool now = shape.distance(p) < 0.0;
      fingers += now && !inside ? 1 : 0;
      inside = now;
    }
    EXPECT_EQ(fingers, 4);
  }
}

TEST(Bodies, AFingerBendsAlone) {
  const Body& body = anna();
  const auto mesh = posed(body, turned(body, Joint::index1_left, -60.0, Eigen::Vector3d::UnitX()));
  const auto tip_of = [&](Joint last) {  // the vertex farthest beyond the finger's last joint
    const Eigen::Vector3f joint = body.skeleton.joint[index(last)].cast<float>();
    std::size_t tip = 0;
    float best = -1.0F;
    for (std::size_t v = 0; v < body.weights.size(); ++v) {
      if (body.weights[v].joint[0] != index(last)) continue;
      const float distance = (body.bind.positions[v] - joint).norm();
      if (distance > best) best = distance, tip = v;
    }
    EXPECT_GT(best, 0.02F);
    return tip;
  };
  const auto moved = [&](Joint last) {
    const std::size_t v = tip_of(last);
    return (mesh.positions[v] - body.bind.positions[v]).norm();
  };
  EXPECT_GT(moved(Joint::index2_left), 0.05F);
  EXPECT_LT(moved(Joint::middle2_left), 0.004F);
  EXPECT_LT(moved(Joint::thumb2_left), 0.004F);
}

TEST(Bodies, KeepTheirVolumeWhenALimbBends) {
  const Body& body = anna();
  const double bind = recon::signed_volume(body.bind);
  const std::vector<Pose> poses = {turned(body, Joint::shank_left, 90.0, Eigen::Vector3d::UnitY()),
                                   turned(body, Joint::thigh_left, -80.0, Eigen::Vector3d::UnitY()),
                                   turned(body, Joint::forearm_left, -90.0, Eigen::Vector3d::UnitY()),
                                   turned(body, Joint::upper_arm_left, 100.0, Eigen::Vector3d::UnitX())};
  for (const auto& pose : poses) EXPECT_NEAR(recon::signed_volume(posed(body, pose)) / bind, 1.0, 0.04);
}

// Turned by 160 degrees about its own axis the forearm does not shrink to a point, as blended matrices would.
TEST(Bodies, ATwistedForearmKeepsItsThickness) {
  const Body& body = anna();
  const auto at = [&](Joint joint) { return body.skeleton.joint[index(joint)]; };
  const Eigen::Vector3d axis = (at(Joint::hand_left) - at(Joint::forearm_left)).normalized();
  const auto mesh = posed(body, turned(body, Joint::hand_left, 160.0, axis));
  const auto thinnest = [&](const recon::TriangleMesh& surface) {
    double thin = 1.0;
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      const Eigen::Vector3d from = body.bind.positions[v].cast<double>() - at(Joint::hand_left);
      if (from.norm() > 0.05 || std::abs(from.dot(axis)) > 0.02) continue;
      const Eigen::Vector3d now = surface.positions[v].cast<double>() - at(Joint::hand_left);
      thin = std::min(thin, (now - axis * axis.dot(now)).norm());
    }
    return thin;
  };
  EXPECT_GT(thinnest(mesh), 0.8 * thinnest(body.bind));
}

TEST(Bodies, WeightsSumToOne) {
  for (const auto& weights : anna().weights) {
    float sum = 0.0F;
    for (const float w : weights.weight) sum += w;
    ASSERT_NEAR(sum, 1.0F, 1e-5F);
  }
}

TEST(Bodies, AreTheSameEveryTime) {
  const Body again = coarse_body("anna");
  ASSERT_EQ(again.bind.positions.size(), anna().bind.positions.size());
  for (std::size_t v = 0; v < again.bind.positions.size(); ++v)
    ASSERT_EQ(again.bind.positions[v], anna().bind.positions[v]);
}

}  // namespace
}  // namespace rotunda::simulator
