#include "simulator/people/cloth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <unordered_map>

#include "simulator/people/body_mesh.h"

namespace rotunda::simulator {
namespace {

using Eigen::Vector3d;
using Neighbours = std::vector<std::vector<std::uint32_t>>;
constexpr double kLeastLooseness = 0.02;
constexpr double kSkin = 0.003;  // metres that cloth keeps off the body
constexpr std::uint32_t kNone = ~0U;

struct Surface {
  const recon::TriangleMesh& mesh;
  Neighbours neighbours;
  std::vector<double> looseness;
  std::vector<Garment> garment;
  std::vector<std::uint8_t> on_trunk;  // no part of an arm
  bool loose(std::size_t v) const { return looseness[v] > kLeastLooseness; }
  Vector3d at(std::size_t v) const { return mesh.positions[v].cast<double>(); }
  Vector3d normal(std::size_t v) const { return mesh.normals[v].cast<double>(); }
};

bool is_arm(Joint joint) {
  return (joint >= Joint::upper_arm_left && joint < Joint::clavicle_right) ||
         (joint >= Joint::upper_arm_right && joint < Joint::thigh_left);
}

Surface surface_of(const recon::TriangleMesh& mesh, const BodyShape& shape) {
  Surface surface{mesh, neighbours_of(mesh), std::vector<double>(mesh.positions.size()),
                  std::vector<Garment>(mesh.positions.size()), std::vector<std::uint8_t>(mesh.positions.size())};
  tbb::parallel_for(std::size_t{0}, mesh.positions.size(), [&](std::size_t v) {
    const Vector3d p = surface.at(v);
    const BodyPlace place = shape.place_of(p);
    surface.garment[v] = place.worn.garment;
    surface.on_trunk[v] = is_arm(place.joint) ? 0 : 1;
    surface.looseness[v] = surface.garment[v] == Garment::bare ? 0.0 : shape.looseness(p);
  });
  return surface;
}

bool hangs(Garment garment) {
  return garment == Garment::skirt || garment == Garment::coat;
}

// Shortest ways along the edges among the vertices allowed: metres, and the source each is reached from.
struct Reach {
  std::vector<double> metres;
  std::vector<std::uint32_t> source;
};
template <class Allowed>
Reach reach_from(const Surface& surface, const std::vector<std::uint32_t>& sources, const Allowed& allowed) {
  Reach reach{std::vector<double>(surface.mesh.positions.size(), std::numeric_limits<double>::max()),
              std::vector<std::uint32_t>(surface.mesh.positions.size(), kNone)};
  using Step = std::pair<double, std::uint32_t>;
  std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
  for (std::uint32_t i = 0; i < sources.size(); ++i) {
    reach.metres[sources[i]] = 0.0;
    reach.source[sources[i]] = i;
    open.emplace(0.0, sources[i]);
  }
  while (!open.empty()) {
    const auto [metres, v] = open.top();
    open.pop();
    if (metres > reach.metres[v]) continue;
    for (const auto n : surface.neighbours[v]) {
      const double way = metres + (surface.at(n) - surface.at(v)).norm();
      if (!allowed(n) || way >= reach.metres[n]) continue;
      reach.metres[n] = way;
      reach.source[n] = reach.source[v];
      open.emplace(way, n);
    }
  }
  return reach;
}

// Vertices of the loose cloth no two of which are closer than `spacing` (dart throwing in the mesh's own order).
std::vector<std::uint32_t> spread(const Surface& surface, double spacing) {
  std::vector<std::uint32_t> chosen;
  std::map<std::array<int, 3>, std::vector<std::uint32_t>> cells;
  const auto cell_of = [&](const Vector3d& p) {
    const Eigen::Vector3i c = (p / spacing).array().floor().cast<int>();
    return std::array<int, 3>{c.x(), c.y(), c.z()};
  };
  const auto crowded = [&](std::uint32_t v) {
    const auto c = cell_of(surface.at(v));
    for (int k = 0; k < 27; ++k) {
      const auto near = cells.find({c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1});
      if (near == cells.end()) continue;
      for (const auto u : near->second)
        if ((surface.at(u) - surface.at(v)).norm() < spacing && surface.normal(u).dot(surface.normal(v)) > -0.2)
          return true;
    }
    return false;
  };
  for (std::uint32_t v = 0; v < surface.mesh.positions.size(); ++v) {
    if (!surface.loose(v) || crowded(v)) continue;
    chosen.push_back(v);
    cells[cell_of(surface.at(v))].push_back(v);
  }
  return chosen;
}

using Ties = std::vector<std::set<std::uint32_t>>;

// Particles whose regions touch are tied.
Ties ties_between(const Surface& surface, const Reach& reach, std::size_t particles) {
  Ties ties(particles);
  for (std::size_t v = 0; v < reach.source.size(); ++v) {
    if (!surface.loose(v) || reach.source[v] == kNone) continue;
    for (const auto n : surface.neighbours[v])
      if (surface.loose(n) && reach.source[n] != kNone && reach.source[n] != reach.source[v])
        ties[reach.source[v]].insert(reach.source[n]);
  }
  return ties;
}

std::vector<ClothBond> bonds_of(const Surface& surface, const std::vector<std::uint32_t>& vertices, const Ties& ties) {
  std::vector<ClothBond> bonds;
  const auto add = [&](std::uint32_t a, std::uint32_t b, bool bends) {
    bonds.push_back({a, b, (surface.at(vertices[a]) - surface.at(vertices[b])).norm(), bends});
  };
  for (std::uint32_t a = 0; a < ties.size(); ++a)
    for (const auto b : ties[a])
      if (a < b) add(a, b, false);
  std::set<std::pair<std::uint32_t, std::uint32_t>> bent;
  for (std::uint32_t middle = 0; middle < ties.size(); ++middle)
    for (const auto a : ties[middle])
      for (const auto b : ties[middle]) {
        const Vector3d to_a = surface.at(vertices[a]) - surface.at(vertices[middle]);
        const Vector3d to_b = surface.at(vertices[b]) - surface.at(vertices[middle]);
        if (a < b && to_a.normalized().dot(to_b.normalized()) < -0.75 && !ties[a].count(b) &&
            bent.insert({a, b}).second)
          add(a, b, true);
      }
  return bonds;
}

// Follows the particles about its own by their nearness (a Wendland kernel).
ClothFollower follower_of(const Surface& surface, std::uint32_t vertex, std::uint32_t own, const Ties& ties,
                          const std::vector<std::uint32_t>& vertices, double radius, double whole) {
  std::set<std::uint32_t> about{own};
  for (const auto n : ties[own]) {
    about.insert(n);
    about.insert(ties[n].begin(), ties[n].end());
  }
  std::vector<std::pair<double, std::uint32_t>> near;
  for (const auto particle : about)
    near.emplace_back((surface.at(vertices[particle]) - surface.at(vertex)).norm(), particle);
  std::sort(near.begin(), near.end());
  ClothFollower follower;
  follower.vertex = vertex;
  follower.hangs = hangs(surface.garment[vertex]);
  follower.meets_arms = surface.on_trunk[vertex] != 0;
  double sum = 0.0;
  std::array<double, ClothFollower::kParticles> weight{};
  const double reach = std::max(radius, 1.2 * near.front().first);
  for (std::size_t i = 0; i < std::min(near.size(), ClothFollower::kParticles); ++i) {
    const double x = near[i].first / reach;
    weight[i] = x < 1.0 ? std::pow(1.0 - x, 4) * (4.0 * x + 1.0) : 0.0;
    follower.particle[i] = near[i].second;
    sum += weight[i];
  }
  for (std::size_t i = 0; i < weight.size(); ++i) follower.share[i] = static_cast<float>(whole * weight[i] / sum);
  return follower;
}

// The lining follows the hem, less and less towards the legs.
void add_lining(Cloth& cloth, const Surface& surface, const Reach& from_particles, const Ties& ties,
                const std::vector<std::uint32_t>& vertices, double radius) {
  std::vector<std::uint32_t> legs;
  for (std::uint32_t v = 0; v < surface.garment.size(); ++v)
    if (!surface.loose(v) && surface.garment[v] != Garment::lining) legs.push_back(v);
  const auto is_lining = [&](std::size_t v) { return surface.garment[v] == Garment::lining && !surface.loose(v); };
  const Reach from_legs = reach_from(surface, legs, is_lining);
  for (std::uint32_t v = 0; v < surface.garment.size(); ++v) {
    if (!is_lining(v) || from_particles.source[v] == kNone) continue;
    const double to_leg = from_legs.source[v] == kNone ? 1.0 : from_legs.metres[v];
    const double whole = to_leg / (to_leg + from_particles.metres[v] + 1e-6);
    cloth.lining.push_back(
        follower_of(surface, v, from_particles.source[v], ties, vertices, radius + from_particles.metres[v], whole));
    cloth.round.push_back(surface.neighbours[v]);
  }
}

BodyField body_about(const Surface& surface, const std::vector<ClothParticle>& particles, const BodyShape& shape) {
  constexpr double kRoom = 0.12, kCell = 0.015;  // metres: cloth that is farther off meets nothing
  Eigen::AlignedBox3d box;
  for (const auto& particle : particles)
    if (particle.off_body) box.extend(surface.at(particle.vertex));
  if (box.isEmpty()) return {};
  box.extend(box.min() - Vector3d::Constant(kRoom));
  box.extend(box.max() + Vector3d::Constant(kRoom));
  return {box, kCell, [&](const Vector3d& p) { return shape.bare_distance(p); }};
}

void add_limb(std::vector<LimbCapsule>& limbs, const BodyShape& shape, Joint joint, const Vector3d& from,
              const Vector3d& to, int pieces) {
  const auto radius = [&](const Vector3d& p) { return std::max(0.0, -shape.bare_distance(p)); };
  for (int i = 0; i < pieces; ++i) {
    const Vector3d a = from + (to - from) * i / pieces, b = from + (to - from) * (i + 1) / pieces;
    limbs.push_back({joint, a, b, radius(a), radius(b)});
  }
}

// The arm swings beside the trunk: from above the elbow, since the rest never leaves it, to the knuckles.
void add_arms(Cloth& cloth, const BodyShape& shape, const Skeleton& skeleton) {
  for (const Side side : {Side::left, Side::right}) {
    const auto at = [&](Joint left) -> Vector3d { return skeleton.joint[index(on_side(left, side))]; };
    const Vector3d shoulder = at(Joint::upper_arm_left), elbow = at(Joint::forearm_left), wrist = at(Joint::hand_left);
    add_limb(cloth.arms, shape, on_side(Joint::upper_arm_left, side), shoulder + 0.55 * (elbow - shoulder), elbow, 2);
    add_limb(cloth.arms, shape, on_side(Joint::forearm_left, side), elbow, wrist, 3);
    add_limb(cloth.arms, shape, on_side(Joint::hand_left, side), wrist, at(Joint::middle1_left), 1);
  }
}

void add_legs(Cloth& cloth, const BodyShape& shape, const Skeleton& skeleton) {
  for (const Side side : {Side::left, Side::right}) {
    const auto at = [&](Joint left) -> Vector3d { return skeleton.joint[index(on_side(left, side))]; };
    const Vector3d hip = at(Joint::thigh_left), knee = at(Joint::shank_left), ankle = at(Joint::foot_left);
    add_limb(cloth.limbs, shape, on_side(Joint::thigh_left, side), hip + 0.20 * (knee - hip), knee, 3);
    add_limb(cloth.limbs, shape, on_side(Joint::shank_left, side), knee, knee + 0.8 * (ankle - knee), 3);
  }
}

}  // namespace

Depth depth_in(const Vector3d& a, const Vector3d& b, double radius_a, double radius_b, const Vector3d& p) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  const Vector3d from = p - a - t * (b - a);
  const double distance = from.norm();
  return {radius_a + t * (radius_b - radius_a) - distance, from / std::max(distance, 1e-9)};
}

Cloth cloth_of(const recon::TriangleMesh& bind, const BodyShape& shape, const Skeleton& skeleton, double spacing) {
  const Surface surface = surface_of(bind, shape);
  const auto vertices = spread(surface, spacing);
  Cloth cloth;
  if (vertices.empty()) return cloth;
  const double hips = skeleton.joint[index(Joint::thigh_left)].z();
  for (const auto v : vertices) {
    const double bare = shape.bare_distance(surface.at(v));
    ClothParticle particle{
        v, surface.looseness[v], std::max(0.0, bare - kSkin), hangs(surface.garment[v]), surface.on_trunk[v] != 0, {}};
    if (!particle.hangs || surface.at(v).z() > hips) particle.off_body = std::min(bare, kSkin);
    cloth.particles.push_back(particle);
  }
  cloth.body = body_about(surface, cloth.particles, shape);
  const Reach reach = reach_from(
      surface, vertices, [&](std::size_t v) { return surface.loose(v) || surface.garment[v] == Garment::lining; });
  const Ties ties = ties_between(surface, reach, vertices.size());
  cloth.bonds = bonds_of(surface, vertices, ties);
  for (std::uint32_t v = 0; v < bind.positions.size(); ++v)
    if (surface.loose(v) && reach.source[v] != kNone)
      cloth.followers.push_back(follower_of(surface, v, reach.source[v], ties, vertices, 2.2 * spacing, 1.0));
  add_lining(cloth, surface, reach, ties, vertices, 2.2 * spacing);
  add_legs(cloth, shape, skeleton);
  add_arms(cloth, shape, skeleton);
  return cloth;
}

}  // namespace rotunda::simulator
