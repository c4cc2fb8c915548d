#include "recon/deform/poisson_deform.h"

#include <gtest/gtest.h>

#include <numbers>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Eigen::AngleAxisf;
using Eigen::Quaternionf;
using Eigen::Vector3f;

constexpr float kLength = 0.6F, kRadius = 0.06F;
constexpr std::size_t kRings = 61, kAround = 40;

// A limb along x about the origin, closed by a pole at either end.
TriangleMesh limb() {
  TriangleMesh mesh;
  for (std::size_t r = 0; r < kRings; ++r)
    for (std::size_t k = 0; k < kAround; ++k) {
      const float phi = 2.0F * std::numbers::pi_v<float> * static_cast<float>(k) / kAround;
      mesh.positions.emplace_back(kLength * (static_cast<float>(r) / (kRings - 1) - 0.5F), kRadius * std::cos(phi),
                                  kRadius * std::sin(phi));
    }
  const auto at = [](std::size_t r, std::size_t k) { return static_cast<std::uint32_t>(r * kAround + k % kAround); };
  const auto first = static_cast<std::uint32_t>(mesh.positions.size()), last = first + 1;
  mesh.positions.emplace_back(-0.5F * kLength, 0.0F, 0.0F);
  mesh.positions.emplace_back(0.5F * kLength, 0.0F, 0.0F);
  for (std::size_t k = 0; k < kAround; ++k) {
    mesh.triangles.push_back({first, at(0, k + 1), at(0, k)});
    for (std::size_t r = 0; r + 1 < kRings; ++r) {
      mesh.triangles.push_back({at(r, k), at(r, k + 1), at(r + 1, k)});
      mesh.triangles.push_back({at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)});
    }
    mesh.triangles.push_back({last, at(kRings - 1, k), at(kRings - 1, k + 1)});
  }
  return mesh;
}

// Both ends are held, 0.4 m amid them are free: the span of field measurements of the paper's method.
std::vector<HeldVertex> ends(const TriangleMesh& mesh) {
  std::vector<HeldVertex> held;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
    if (std::abs(mesh.positions[v].x()) > 0.2F) held.push_back({v, mesh.positions[v].x() < 0.0F ? 0U : 1U});
  return held;
}

PoissonDeform make(const TriangleMesh& mesh, bool as_paper = false) {
  PoissonDeformOptions options{.handles = 2, .hold_positions = !as_paper, .joints = {}, .bridges = {}};
  if (!as_paper) options.joints = {{.a = 0, .b = 1, .centre = Vector3f::Zero()}};
  return PoissonDeform(mesh, ends(mesh), options);
}

std::vector<Vector3f> pose_of(PoissonDeform& deform, std::vector<HandlePose> poses) {
  agree_in_sign(poses, std::vector<int>{-1, 0});
  std::vector<Vector3f> positions(poses.size() / 2 * deform.vertices());
  deform.deform(poses, positions);
  return positions;
}

HandlePose turned(float degrees, const Vector3f& axis) {
  return {Quaternionf(AngleAxisf(degrees * std::numbers::pi_v<float> / 180.0F, axis)), Vector3f::Zero()};
}

double volume_change(const TriangleMesh& rest, const std::vector<Vector3f>& positions) {
  TriangleMesh posed = rest;
  posed.positions = positions;
  return signed_volume(posed) / signed_volume(rest) - 1.0;
}

float drift(const TriangleMesh& mesh, const std::vector<Vector3f>& positions, const std::vector<HandlePose>& poses) {
  float worst = 0.0F;
  for (const auto& held : ends(mesh)) {
    const auto& pose = poses[held.handle];
    const Vector3f wanted = pose.rotation * mesh.positions[held.vertex] + pose.translation;
    worst = std::max(worst, (positions[held.vertex] - wanted).norm());
  }
  return worst;
}

TEST(PoissonDeform, LeavesTheRestPoseAndRigidMotionsAsTheyAre) {
  const auto mesh = limb();
  auto deform = make(mesh);
  const HandlePose moved{turned(130, Vector3f(1, 2, 3).normalized()).rotation, {3, -2, 1}};
  const auto positions = pose_of(deform, {{}, {}, moved, moved});
  float worst = 0.0F;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    worst = std::max(worst, (positions[v] - mesh.positions[v]).norm());
    const Vector3f rigid = moved.rotation * mesh.positions[v] + moved.translation;
    worst = std::max(worst, (positions[deform.vertices() + v] - rigid).norm());
  }
  EXPECT_LT(worst, 2e-5F);  // a hundredth of a millimetre: float32 at metres, factor and all
}

TEST(PoissonDeform, HoldsPlacesAndVolumeWhereThePapersMethodDoesNot) {
  const auto mesh = limb();
  auto ours = make(mesh), paper = make(mesh, true);
  for (const auto& pose :
       {turned(90, Vector3f::UnitZ()), turned(90, Vector3f::UnitX()), turned(-90, Vector3f(0, 1, 1).normalized())}) {
    const std::vector<HandlePose> poses{{}, pose};
    const auto positions = pose_of(ours, poses);
    EXPECT_LT(drift(mesh, positions, poses), 1e-5F);
    EXPECT_LT(std::abs(volume_change(mesh, positions)), 0.03);
  }
  const std::vector<HandlePose> bent{{}, turned(90, Vector3f::UnitZ())};
  EXPECT_GT(drift(mesh, pose_of(paper, bent), bent), 0.02F);  // nothing but the first vertex is held there
}

TEST(PoissonDeform, GivesAFrameTheSameShapeAloneAndAmongOthers) {
  const auto mesh = limb();
  auto deform = make(mesh);
  std::vector<HandlePose> poses;
  for (int f = 0; f < 37; ++f) {
    poses.emplace_back();
    poses.push_back(turned(3.0F * static_cast<float>(f), Vector3f(1, 1, 0).normalized()));
  }
  const auto all = pose_of(deform, poses);
  const auto alone = pose_of(deform, {poses[2 * 29], poses[2 * 29 + 1]});
  EXPECT_TRUE(
      std::equal(alone.begin(), alone.end(), all.begin() + static_cast<std::ptrdiff_t>(29 * deform.vertices())));
}

// q and -q turn a limb alike; between one and the other the field would pass through zero.
TEST(PoissonDeform, RunsTheShortWayWhateverTheSigns) {
  const auto mesh = limb();
  auto deform = make(mesh);
  auto pose = turned(60, Vector3f::UnitX());
  const auto wanted = pose_of(deform, {{}, pose});
  pose.rotation.coeffs() = -pose.rotation.coeffs();
  EXPECT_EQ(pose_of(deform, {{}, pose}), wanted);
}

TEST(PoissonDeform, RefusesHandlesThatAreNotThereOrContradict) {
  const auto mesh = limb();
  const PoissonDeformOptions options{.handles = 2, .hold_positions = true, .joints = {}, .bridges = {}};
  const std::vector<HeldVertex> twice{{0, 0}, {0, 1}}, beyond{{0, 2}}, missing{{999'999, 0}};
  EXPECT_THROW(PoissonDeform(mesh, twice, options), InvalidInput);
  EXPECT_THROW(PoissonDeform(mesh, beyond, options), InvalidInput);
  EXPECT_THROW(PoissonDeform(mesh, missing, options), InvalidInput);
  EXPECT_THROW(PoissonDeform(mesh, {}, options), InvalidInput);
}

}  // namespace
}  // namespace rotunda::recon
