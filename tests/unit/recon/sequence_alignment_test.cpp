#include "recon/video/sequence_alignment.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "config/errors.h"
#include "recon/alignment_store.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/sphere/resample.h"
#include "recon/sphere/sphere_map.h"
#include "recon/track/body_surface.h"
#include "recon/track/deformation_graph.h"
#include "recon/track/settled_surface.h"
#include "recon/track/skinned_prior.h"
#include "recon/video/geometry_video.h"
#include "tests/support/bent_starfish.h"

namespace rotunda::recon {
namespace {

using Eigen::Vector3d;

TEST(DeformationGraph, MovesRigidlyWhatMovesAsOne) {
  const auto mesh = tests::bent_starfish(0.0, 0.0, 3);
  const auto graph = deformation_graph(mesh, 40);
  ASSERT_EQ(graph.nodes.size(), 40U);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.8, Vector3d(1.0, 0.0, 1.0).normalized()).toRotationMatrix();
  const Vector3d shift(0.3, -0.2, 1.0);
  std::vector<NodeMotion> motion;
  for (const auto& node : graph.nodes) motion.push_back({turn, turn * node + shift - node});
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto& binding = graph.bindings[v];
    EXPECT_NEAR(binding.weight[0] + binding.weight[1] + binding.weight[2] + binding.weight[3], 1.0, 1e-12);
    const Vector3d rest = mesh.positions[v].cast<double>();
    EXPECT_LT((moved(graph, motion, binding, rest) - (turn * rest + shift)).norm(), 1e-9);
  }
}

TEST(GeodesicWays, ComeNearToTheGreatCircle) {
  const auto ball = tests::icosphere(4);
  const GeodesicWays ways(ball);
  std::vector<double> distances(ways.size(), 1e9);
  ways.spread({0}, distances);
  for (std::size_t v = 1; v < ball.positions.size(); ++v) {
    const double arc = std::acos(std::clamp(static_cast<double>(ball.positions[0].dot(ball.positions[v])), -1.0, 1.0));
    EXPECT_GT(distances[v], 0.99 * arc);
    EXPECT_LT(distances[v], 1.08 * arc);
  }
}

TEST(GeometryVideoHeader, TellsThatItIsAligned) {
  GeometryVideoHeader header;
  header.box = {Vector3d::Zero(), Vector3d::Ones()};
  header.root_path = {Vector3d::Zero()};
  header.statuses.resize(1);
  EXPECT_FALSE(header_from_json(to_json(header)).aligned);
  header.aligned = true;
  const auto back = header_from_json(to_json(header));
  EXPECT_TRUE(back.aligned);
  EXPECT_EQ(back.version, 1);  // what older programs read stays readable for them
}

// A person of 1.8 m who raises an arm, bends a knee and walks off.
Pose striding(double share) {
  auto pose = free_pose();
  pose.root = Vector3d(0.2 * share, 0.1, 1.0);
  const auto turn = [&](BodyJoint joint, double angle, const Vector3d& axis) {
    auto& rotation = pose.rotation[index(joint)];
    rotation = (rotation * Eigen::Quaterniond(Eigen::AngleAxisd(share * angle, axis))).normalized();
  };
  turn(BodyJoint::upper_arm_left, 0.8, Vector3d::UnitX());
  turn(BodyJoint::thigh_right, -0.7, Vector3d::UnitY());
  turn(BodyJoint::shank_right, 0.9, Vector3d::UnitY());
  turn(BodyJoint::pelvis, 0.5, Vector3d::UnitZ());
  return pose;
}

// What nobody tells the alignment: where a point of the body, given at rest by its nearest segment, is in a pose.
class Truth {
 public:
  explicit Truth(const BodyTemplate& body) : body_(body) {}
  TriangleMesh surface(const Pose& pose, double cell) const { return body_surface(body_, pose, cell); }
  double error(const Vector3d& at_a, const Pose& a, const Vector3d& at_b, const Pose& b) const {
    const auto posed = pose_template(body_, a);
    std::size_t nearest = 0;
    for (std::size_t v = 0; v < posed.positions.size(); ++v)
      if ((posed.positions[v].cast<double>() - at_a).norm() < (posed.positions[nearest].cast<double>() - at_a).norm())
        nearest = v;
    const auto joint = index(joint_of_segment(nearest / vertices_of_segment()));
    const auto from = joint_transforms(body_.skeleton, a), to = joint_transforms(body_.skeleton, b);
    return (to[joint] * (from[joint].inverse() * at_a) - at_b).norm();
  }

 private:
  const BodyTemplate& body_;
};

constexpr double kCell = 0.03;

TEST(BodySurface, IsOneClosedBodyOfTheTemplatesHeight) {
  const auto body = template_of_height(1.8);
  const auto mesh = body_surface(body, free_pose(), kCell);
  EXPECT_TRUE(topology_of(mesh).is_sphere());
  EXPECT_GT(signed_volume(mesh), 0.05);  // a person of 60 to 90 kg
  EXPECT_LT(signed_volume(mesh), 0.09);
  Eigen::AlignedBox3f box;
  for (const auto& position : mesh.positions) box.extend(position);
  EXPECT_NEAR(box.sizes().z(), 1.78, 0.06);  // legs a little apart
}

TEST(SkinnedPrior, FollowsTheBones) {
  const auto body = template_of_height(1.8);
  const auto mesh = body_surface(body, free_pose(), kCell);
  const SurfaceModel model(mesh);
  const SkinnedPrior prior(model, body, free_pose());
  for (const auto& weights : prior.weights()) {
    double sum = 0.0;
    for (const double weight : weights) sum += weight;
    EXPECT_NEAR(sum, 1.0, 1e-9);
  }
  const auto still = model.moved(prior.posed(body.skeleton, free_pose()));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_LT((still.positions[v] - mesh.positions[v]).norm(), 1e-5F);
  const auto pose = striding(1.0);
  const auto moved = model.moved(prior.posed(body.skeleton, pose));
  std::vector<double> errors;
  const Truth truth(body);
  for (std::size_t v = 0; v < mesh.positions.size(); v += 7)
    errors.push_back(
        truth.error(mesh.positions[v].cast<double>(), free_pose(), moved.positions[v].cast<double>(), pose));
  EXPECT_LT(tests::mean_of(errors), 0.015);
  EXPECT_GT(tests::share_within(errors, 0.05), 0.95);
}

TEST(Settle, LeavesNoFoldAndComesNearer) {
  auto ball = tests::icosphere(3);
  for (auto& position : ball.positions) position *= 0.2F;
  compute_normals(ball);
  auto carried = ball;
  for (std::size_t v = 0; v < carried.positions.size(); ++v) carried.positions[v] += 0.01F * ball.normals[v];
  std::swap(carried.positions[20], carried.positions[30]);  // folds what is around them
  const auto settled = settle(carried, SurfaceTarget(ball));
  EXPECT_EQ(settled.folds, 0U);
  EXPECT_LT(settled.residual_mean_mm, 2.0);
}

TEST(Settle, TellsTheShareOfASurfaceThatItDoesNotReach) {
  auto ball = tests::icosphere(3);
  for (auto& position : ball.positions) position *= 0.2F;
  compute_normals(ball);
  EXPECT_EQ(settle(ball, SurfaceTarget(ball)).uncovered, 0.0);
  auto both = ball;  // and a second ball half as large beside it: a fifth of the area
  const auto count = static_cast<std::uint32_t>(ball.positions.size());
  for (const auto& position : ball.positions) both.positions.push_back(0.5F * position + Eigen::Vector3f(0.6F, 0, 0));
  for (const auto& t : ball.triangles) both.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  compute_normals(both);
  EXPECT_NEAR(settle(ball, SurfaceTarget(both)).uncovered, 0.2, 0.01);
}

// One reference for two "takes": the poses of both, one of a person measured a little taller.
TEST(SequenceAlignment, EverySampleIsTheSamePointOfTheBodyInEveryPose) {
  const auto body = template_of_height(1.8);
  const Truth truth(body);
  BodyTrack track{.body = body, .first_frame = 0, .poses = {}};
  for (int i = 0; i < 7; ++i) track.poses.emplace_back(striding(i / 6.0));
  track.poses[3].reset();
  const auto steady = steadied(track);
  ASSERT_TRUE(steady.poses[3]);  // bridged
  EXPECT_LT((steady.poses[3]->root - striding(0.5).root).norm(), 1e-3);
  const auto load = [&](std::size_t i) -> std::optional<TriangleMesh> {
    if (i == 1 || i == 2 || i == 4 || i == 5) return std::nullopt;  // as if their surfaces had failed
    return truth.surface(striding(static_cast<double>(i) / 6.0), kCell);
  };
  const auto reference = body_reference(steady, 5, load);
  ASSERT_TRUE(reference);
  const BodyCarrier carrier(*reference);
  const auto first = carrier.align(*load(0), steady.body.skeleton, *steady.pose(0));
  const auto last = carrier.align(*load(6), steady.body.skeleton, *steady.pose(6));
  EXPECT_EQ(first.folds, 0U);
  EXPECT_EQ(last.folds, 0U);
  EXPECT_LT(last.uncovered, 0.02);
  EXPECT_LT(last.residual_mean_mm, 5.0);
  ASSERT_EQ(first.image.positions.size(), 33U * 33U);
  std::vector<double> errors;
  for (std::size_t i = 0; i < first.image.positions.size(); ++i)
    errors.push_back(truth.error(first.image.positions[i].cast<double>(), striding(0.0),
                                 last.image.positions[i].cast<double>(), striding(1.0)));
  EXPECT_LT(tests::mean_of(errors), 0.015);
  EXPECT_GT(tests::share_within(errors, 0.05), 0.95);
  const auto again = carrier.align(*load(6), steady.body.skeleton, *steady.pose(6));
  EXPECT_EQ(again.image.positions, last.image.positions);
}

TEST(SequenceAlignment, NobodyIsCarriedByNoSkeleton) {
  EXPECT_THROW(BodyCarrier(AlignmentReference{}), InvalidInput);
  EXPECT_FALSE(key_reference(3, 5, [](std::size_t) { return std::nullopt; }));
}

// What is no person: five frames of a starfish that waves and turns; one failed.
TEST(SequenceAlignment, WhatHasNoSkeletonIsTracked) {
  constexpr std::size_t kFrames = 5, kFailed = 1;
  std::vector<TriangleMesh> meshes;
  for (std::size_t i = 0; i < kFrames; ++i)
    meshes.push_back(tests::bent_starfish(0.06 * static_cast<double>(i), 0.05 * static_cast<double>(i)));
  const auto load = [&](std::size_t i) { return i == kFailed ? std::nullopt : std::optional(meshes[i]); };
  const auto key = key_reference(kFrames, 5, [&](std::size_t i) -> std::optional<MappedSurface> {
    if (i == kFailed) return std::nullopt;
    return MappedSurface{meshes[i], map_to_sphere(meshes[i]).map.value()};
  });
  ASSERT_TRUE(key);
  std::map<std::size_t, AlignedFrame> aligned;
  track_sequence(kFrames, *key, load, [&](std::size_t i, const AlignedFrame& frame) { aligned.emplace(i, frame); });
  ASSERT_EQ(aligned.size(), kFrames - 1);
  for (const auto& [i, frame] : aligned) {
    EXPECT_EQ(frame.folds, 0U);
    const auto errors = tests::correspondence_errors(aligned.at(0).image, meshes[0], frame.image, meshes[i]);
    EXPECT_LT(tests::mean_of(errors), 0.04) << "frame " << i;  // limbs of a metre; samples are 0.06 m apart
  }
}

TEST(AlignmentStore, KeepsTheReferenceAndTellsDamage) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "alignment_store";
  std::filesystem::remove_all(folder);
  const AlignmentStore store(folder, "{}");
  EXPECT_FALSE(store.reference());
  const auto body = template_of_height(1.7);
  AlignmentReference reference{
      .surface = {.mesh = tests::bent_starfish(0.1, 0.0, 3), .map = {}}, .lattice = {}, .body = body};
  reference.surface.map = map_to_sphere(reference.surface.mesh).map.value();
  reference.lattice = lattice_directions(4);
  store.save_reference(reference);
  const auto back = store.reference();
  ASSERT_TRUE(back);
  ASSERT_TRUE(back->body);
  EXPECT_EQ(back->body->measures, body.measures);
  EXPECT_EQ(back->lattice, reference.lattice);
  EXPECT_EQ(back->surface.map.points, reference.surface.map.points);
  auto image = resample(back->surface.mesh, back->surface.map, back->lattice);
  image.colour_level = image.level;
  image.colours.assign(image.positions.size(), {1, 2, 3});
  image.coverage.assign(image.positions.size(), 255);
  EXPECT_FALSE(store.finished(3));
  store.save(3, image, "{}");
  EXPECT_TRUE(store.finished(3));
  EXPECT_EQ(store.image(3).positions, image.positions);
  std::swap(reference.lattice[3], reference.lattice[4]);
  reference.surface.map.points.pop_back();
  store.save_reference(reference);
  EXPECT_THROW(store.reference(), CorruptData);
  std::filesystem::resize_file(folder / "reference.lattice.tiff", 100);
  EXPECT_THROW(store.reference(), CorruptData);
  const AlignmentStore other(folder, R"({"version":2})");
  EXPECT_FALSE(other.finished(3));  // made with other settings
}

}  // namespace
}  // namespace rotunda::recon
