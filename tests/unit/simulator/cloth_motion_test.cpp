#include "simulator/people/cloth_motion.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numbers>

#include "simulator/people/act.h"

namespace rotunda::simulator {
namespace {

// A coarser surface: the full one takes long to build under the sanitizers.
Person dressed(Outfit outfit) {
  PersonDescription description{"somebody", BodyBuild{}, Clothing{}};
  description.build.outfit = outfit;
  description.texels_per_edge = 2;
  description.coarseness = 1.4;
  return make_person(description);
}

ClothMotion cloth_of_act(const Person& person, const Motion& motion) {
  return {person, motion.pose_at, {motion.frames, motion.is_cyclic, kActStep}};
}

recon::TriangleMesh surface_at(const Person& person, const ClothMotion& cloth, const Pose& pose, double seconds) {
  const auto transforms = joint_transforms(person.skeleton, pose);
  auto surface = skinned(person.bind, person.weights, transforms);
  cloth.move(person, transforms, seconds, surface);
  return surface;
}

double farthest(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  double far = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) far = std::max(far, static_cast<double>((a[i] - b[i]).norm()));
  return far;
}

double deepest_in_legs(const Person& person, const JointTransforms& transforms, const recon::TriangleMesh& surface) {
  double deepest = -1.0;
  for (const auto& follower : person.cloth.followers)
    for (const auto& limb : person.cloth.limbs) {
      if (!follower.hangs) continue;
      const auto& carried = transforms[index(limb.joint)];
      const auto depth = depth_in(carried * limb.a, carried * limb.b, limb.radius_a, limb.radius_b,
                                  surface.positions[follower.vertex].cast<double>());
      deepest = std::max(deepest, depth.metres);
    }
  return deepest;
}

// Share of the triangles that face against their skinned selves.
double turned_over(const recon::TriangleMesh& surface, const recon::TriangleMesh& skin) {
  const auto facing = [](const recon::TriangleMesh& mesh, const auto& t) -> Eigen::Vector3f {
    const Eigen::Vector3f a = mesh.positions[t[0]];
    return (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a);
  };
  double turned = 0.0;
  for (const auto& t : surface.triangles) turned += facing(surface, t).dot(facing(skin, t)) < 0.0F ? 1.0 : 0.0;
  return turned / static_cast<double>(surface.triangles.size());
}

TEST(ClothMotion, ASkirtSwingsOutsideTheLegsAndTheWalkCloses) {
  const Person person = dressed(Outfit::dress);
  ASSERT_TRUE(recon::topology_of(person.bind).is_sphere());
  const Motion walk = motion_of("walk", person.skeleton);
  const ClothMotion cloth = cloth_of_act(person, walk);
  const double round = walk.frames * kActStep;
  double hem = 0.0, step = 0.0;
  for (int frame = 0; frame < walk.frames; ++frame) {
    const double seconds = frame * kActStep;
    const auto transforms = joint_transforms(person.skeleton, walk.pose_at(seconds));
    EXPECT_LT(deepest_in_legs(person, transforms, surface_at(person, cloth, walk.pose_at(seconds), seconds)), 0.005);
    const auto offsets = cloth.offsets_at(seconds);
    for (const auto& offset : offsets) hem = std::max(hem, static_cast<double>(offset.norm()));
    if (frame > 0) step = std::max(step, farthest(offsets, cloth.offsets_at(seconds - kActStep)));
  }
  EXPECT_GT(hem, 0.03);
  EXPECT_LT(cloth.closing_error(), 0.040);  // periodic but for this before it is spread over the round
  EXPECT_LE(farthest(cloth.offsets_at(round - kActStep), cloth.offsets_at(0.0)), 1.3 * step);  // a step like others
  EXPECT_LT(farthest(cloth.offsets_at(round - 1e-9), cloth.offsets_at(0.0)), 1e-6);
}

TEST(ClothMotion, IsTheSameOnAnyNumberOfThreadsAndRestsUnderItsWeight) {
  const Person person = dressed(Outfit::coat);
  ASSERT_TRUE(recon::topology_of(person.bind).is_sphere());
  const Pose still = bind_pose(person.skeleton);
  const auto stand = [&](double) { return still; };
  const ClothMotionOptions second{.frames = 25, .is_cyclic = false, .frame_seconds = kActStep};
  const ClothMotion resting(person, stand, second);
  EXPECT_LT(farthest(resting.offsets_at(0.0), resting.offsets_at(1.0)), 0.001);
  double sag = 0.0;
  for (const auto& offset : resting.offsets_at(1.0)) sag = std::max(sag, static_cast<double>(-offset.z()));
  EXPECT_GT(sag, 0.001);
  EXPECT_LT(sag, 0.05);
  tbb::task_arena one(1);
  one.execute([&] {
    const ClothMotion again(person, stand, second);
    EXPECT_EQ(farthest(again.offsets_at(0.5), resting.offsets_at(0.5)), 0.0);
  });
}

TEST(ClothMotion, CloseFitStaysWhereTheSkinCarriesIt) {
  const Person person = dressed(Outfit::close_fit);
  ASSERT_TRUE(recon::topology_of(person.bind).is_sphere());
  const Motion walk = motion_of("walk", person.skeleton);
  const ClothMotion cloth = cloth_of_act(person, walk);
  for (int frame = 0; frame < walk.frames; frame += 3) {
    const double seconds = frame * kActStep;
    const auto transforms = joint_transforms(person.skeleton, walk.pose_at(seconds));
    const auto skin = skinned(person.bind, person.weights, transforms);
    EXPECT_LT(farthest(surface_at(person, cloth, walk.pose_at(seconds), seconds).positions, skin.positions), 0.002);
  }
}

// How deep loose cloth of the trunk lies in the arms, metres; a particle is where its own joints' mean carries it.
double deepest_in_arms(const Person& person, const JointTransforms& transforms,
                       const std::vector<Eigen::Vector3f>& offsets) {
  double deepest = -1.0;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const auto& particle = person.cloth.particles[i];
    if (!particle.meets_arms) continue;
    const auto& weights = person.weights[particle.vertex];
    const auto bind = person.bind.positions[particle.vertex].cast<double>();
    Eigen::Vector3d p = offsets[i].cast<double>();
    for (std::size_t k = 0; k < weights.joint.size(); ++k)
      p += static_cast<double>(weights.weight[k]) * (transforms[weights.joint[k]] * bind);
    for (const auto& arm : person.cloth.arms) {
      const auto& carried = transforms[index(arm.joint)];
      deepest = std::max(deepest, depth_in(carried * arm.a, carried * arm.b, arm.radius_a, arm.radius_b, p).metres);
    }
  }
  return deepest;
}

// How deep cloth that lies over trunk and arms is in them, metres: a particle is brought back to the bind pose, where
// the body is known.
double deepest_in_body(const Person& person, const BodyShape& body, const JointTransforms& transforms,
                       const std::vector<Eigen::Vector3f>& offsets) {
  double deepest = -1.0;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const auto& particle = person.cloth.particles[i];
    if (!particle.off_body) continue;
    const auto& weights = person.weights[particle.vertex];
    Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < weights.joint.size(); ++k)
      turn += static_cast<double>(weights.weight[k]) * transforms[weights.joint[k]].linear();
    const Eigen::Vector3d at_rest = person.bind.positions[particle.vertex].cast<double>();
    deepest = std::max(deepest, -body.bare_distance(at_rest + turn.inverse() * offsets[i].cast<double>()));
  }
  return deepest;
}

class LooseCloth : public testing::TestWithParam<Outfit> {};

TEST_P(LooseCloth, KeepsOutOfArmsAndTrunk) {
  const Person person = dressed(GetParam());
  BodyBuild build;
  build.outfit = GetParam();
  const BodyShape body(person.skeleton, build);
  ASSERT_TRUE(recon::topology_of(person.bind).is_sphere());
  constexpr int kFrames = 150;
  for (const std::string act : {"jog", "dance"}) {
    const Motion motion = motion_of(act, person.skeleton);
    const double round = motion.frames * kActStep;
    const auto pose_at = [&](double seconds) { return motion.pose_at(std::fmod(seconds, round)); };
    const ClothMotion cloth(person, pose_at, {.frames = kFrames, .is_cyclic = false, .frame_seconds = kActStep});
    for (int frame = 0; frame < kFrames; ++frame) {
      const double seconds = frame * kActStep;
      const auto offsets = cloth.offsets_at(seconds);
      for (const auto& offset : offsets) ASSERT_TRUE(offset.allFinite()) << act << " frame " << frame;
      if (frame % 10 != 0) continue;
      const auto transforms = joint_transforms(person.skeleton, pose_at(seconds));
      EXPECT_LT(deepest_in_arms(person, transforms, offsets), 0.004) << act << " frame " << frame;
      // The lattice the body is kept on has cells of 15 mm.
      EXPECT_LT(deepest_in_body(person, body, transforms, offsets), 0.006) << act << " frame " << frame;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(ClothMotion, LooseCloth, testing::Values(Outfit::loose_shirt, Outfit::coat));

// Head over heels in 1.2 s with legs that kick: no act is wilder.
TEST(ClothMotion, HoldsTogetherUpsideDown) {
  const Person person = dressed(Outfit::dress);
  const auto somersault = [&](double seconds) {
    const double turn = 2.0 * std::numbers::pi * seconds / 1.2;
    Pose pose = bind_pose(person.skeleton);
    pose.pelvis.z() += 0.3 * std::sin(turn) * std::sin(turn);
    const auto about_y = [](double angle) {
      return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()));
    };
    pose.rotation[index(Joint::pelvis)] = about_y(turn);
    pose.rotation[index(Joint::thigh_left)] = about_y(-1.2 * std::sin(2.0 * turn));
    pose.rotation[index(Joint::thigh_right)] = about_y(1.2 * std::sin(2.0 * turn));
    return pose;
  };
  const ClothMotion cloth(person, somersault, {.frames = 30, .is_cyclic = true, .frame_seconds = kActStep});
  for (int frame = 0; frame < 30; ++frame) {
    const Pose pose = somersault(frame * kActStep);
    const auto surface = surface_at(person, cloth, pose, frame * kActStep);
    const auto skin = posed_mesh(person, pose);
    for (const auto& p : surface.positions) ASSERT_TRUE(p.allFinite());
    EXPECT_LT(farthest(surface.positions, skin.positions), 0.30) << "frame " << frame;
    EXPECT_LT(turned_over(surface, skin), 0.04) << "frame " << frame;
    EXPECT_TRUE(recon::topology_of(surface).is_sphere());
  }
}

}  // namespace
}  // namespace rotunda::simulator
