#include "simulator/people/person.h"

#include <gtest/gtest.h>

#include "config/errors.h"
#include "simulator/people/act.h"
#include "simulator/people/body_mesh.h"
#include "simulator/people/limb_pose.h"

namespace rotunda::simulator {
namespace {

// A coarser surface: the full one takes long to build under the sanitizers.
const Person& alex() {
  static const Person person = [] {
    auto description = describe_person("alex");
    description.texels_per_edge = 2;
    description.coarseness = 1.4;
    return make_person(description);
  }();
  return person;
}

const Motion& walk() {
  static const Motion motion = motion_of("walk", alex().skeleton);
  return motion;
}

double lowest(const recon::TriangleMesh& mesh) {
  double low = 1e9;
  for (const auto& p : mesh.positions) low = std::min(low, static_cast<double>(p.z()));
  return low;
}

TEST(Person, IsOneClosedSurfaceWithoutAHandleOfTwentyToSixtyThousandTriangles) {
  EXPECT_TRUE(recon::topology_of(alex().bind).is_sphere());
  const auto description = describe_person("alex");
  const Skeleton skeleton = make_skeleton(description.build.height);
  const auto mesh = body_mesh(BodyShape(skeleton, description.build), skeleton);
  EXPECT_TRUE(recon::topology_of(mesh).is_sphere());
  EXPECT_GE(mesh.triangles.size(), 20000U);
  EXPECT_LE(mesh.triangles.size(), 60000U);
}

TEST(Person, HasTheSizeOfAnAdult) {
  const auto& mesh = alex().bind;
  double high = 0.0;
  for (const auto& p : mesh.positions) high = std::max(high, static_cast<double>(p.z()));
  EXPECT_NEAR(high, 1.75, 0.03);                 // the height asked for, and hair
  EXPECT_NEAR(lowest(mesh), 0.0, 0.004);         // soles on the floor, to the grid of the surface
  EXPECT_GT(recon::signed_volume(mesh), 0.055);  // an adult is 60 to 80 litres, clothes about 10
  EXPECT_LT(recon::signed_volume(mesh), 0.100);
}

TEST(Person, EveryVertexIsCarriedWholly) {
  for (const auto& weights : alex().weights) {
    float sum = 0.0F;
    for (const float w : weights.weight) sum += w;
    ASSERT_NEAR(sum, 1.0F, 1e-5F);
  }
}

TEST(Person, StaysInTheBindPoseWhenPosedSo) {
  const auto mesh = posed_mesh(alex(), bind_pose(alex().skeleton));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    ASSERT_LT((mesh.positions[v] - alex().bind.positions[v]).norm(), 1e-5F);
}

TEST(Person, StandsOnTheFloorThroughoutTheWalk) {
  for (int frame = 0; frame < walk().frames; ++frame) {
    const auto mesh = posed_mesh(alex(), walk().pose_at(frame * kActStep));
    EXPECT_NEAR(lowest(mesh), 0.0, 0.005) << "frame " << frame;  // 3 mm of gait, 2 mm of the sole's coarse triangles
  }
}

TEST(Person, KeepsItsVolumeWhileItWalks) {
  const double bind = recon::signed_volume(alex().bind);
  for (int frame = 0; frame < walk().frames; frame += 5) {
    const auto mesh = posed_mesh(alex(), walk().pose_at(frame * kActStep));
    EXPECT_NEAR(recon::signed_volume(mesh) / bind, 1.0, 0.03) << "frame " << frame;
  }
}

TEST(Person, AnUnknownNameIsToldWithTheKnownOnes) {
  try {
    make_person("nobody");
    FAIL() << "nobody was made";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("alex"), std::string::npos);
  }
}

}  // namespace
}  // namespace rotunda::simulator
