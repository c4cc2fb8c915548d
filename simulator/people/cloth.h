#pragma once
// What of a person's surface moves by itself: particles spread over the loose cloth, the bonds between them, and the
// vertices that follow them. Bind pose, person frame, metres.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "recon/mesh/triangle_mesh.h"
#include "simulator/people/body_field.h"
#include "simulator/people/body_shape.h"

namespace rotunda::simulator {

// A limb under the cloth: a round cone that a joint carries.
struct LimbCapsule {
  Joint joint = Joint::pelvis;
  Eigen::Vector3d a, b;
  double radius_a = 0.0, radius_b = 0.0;
};

struct ClothParticle {
  std::uint32_t vertex = 0;        // of the mesh
  double looseness = 0.0;          // 0 close to the body, 1 hanging free
  double clearance = 0.0;          // how far it may move towards the body
  bool hangs = false;              // about the legs
  bool meets_arms = false;         // on the trunk: an arm may press it from outside
  std::optional<double> off_body;  // what it keeps off trunk and arms, which carry it alone; nothing: legs do too
};

struct ClothBond {
  std::uint32_t a = 0, b = 0;  // particles
  double length = 0.0;
  bool bends = false;  // over a neighbour: holds the cloth flat
};

struct ClothFollower {
  static constexpr std::size_t kParticles = 6;
  std::uint32_t vertex = 0;
  std::array<std::uint32_t, kParticles> particle{};
  std::array<float, kParticles> share{};  // sum to 1, less on the lining: 0 where it meets the legs
  bool hangs = false, meets_arms = false;
};

struct Cloth {
  std::vector<ClothParticle> particles;
  std::vector<ClothBond> bonds;
  std::vector<ClothFollower> followers;           // the outside of the cloth
  std::vector<ClothFollower> lining;              // what closes it from below
  std::vector<std::vector<std::uint32_t>> round;  // of each lining vertex: the vertices about it
  std::vector<LimbCapsule> limbs;                 // legs
  std::vector<LimbCapsule> arms;                  // from above the elbow to the hand
  BodyField body;                                 // without its clothes, about the particles with `off_body`
};

// `spacing`: of the particles.
Cloth cloth_of(const recon::TriangleMesh& bind, const BodyShape& shape, const Skeleton& skeleton, double spacing);

// How deep a point lies inside the limb, and the way out. Limb and point in one frame.
struct Depth {
  double metres;  // positive inside
  Eigen::Vector3d out;
};
Depth depth_in(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius_a, double radius_b,
               const Eigen::Vector3d& p);

}  // namespace rotunda::simulator
