#include "recon/mesh/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace rotunda::recon {
namespace {

struct EdgeUse {
  int forward = 0;  // from the lower to the higher index
  int backward = 0;
};

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

std::unordered_map<std::uint64_t, EdgeUse> count_edges(const TriangleMesh& mesh) {
  std::unordered_map<std::uint64_t, EdgeUse> edges;
  edges.reserve(mesh.triangles.size() * 3 / 2);
  for (const auto& triangle : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = triangle[i], b = triangle[(i + 1) % 3];
      auto& use = edges[edge_key(a, b)];
      ++(a < b ? use.forward : use.backward);
    }
  return edges;
}

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

std::size_t count_components(const TriangleMesh& mesh, const std::vector<int>& valence) {
  DisjointSets sets(mesh.positions.size());
  for (const auto& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  std::size_t components = 0;
  for (std::uint32_t v = 0; v < valence.size(); ++v)
    if (valence[v] > 0 && sets.find(v) == v) ++components;
  return components;
}

// In a closed mesh each corner (v; a, b) leads on to the corner of v that starts at b; one fan means one cycle.
bool single_fans(const TriangleMesh& mesh, const std::vector<int>& valence) {
  std::unordered_map<std::uint64_t, std::uint32_t> next;  // (v, a) -> b
  next.reserve(mesh.triangles.size() * 3);
  std::vector<std::uint32_t> start(mesh.positions.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      next[(static_cast<std::uint64_t>(t[i]) << 32) | t[(i + 1) % 3]] = t[(i + 2) % 3];
      start[t[i]] = t[(i + 1) % 3];
    }
  for (std::uint32_t v = 0; v < valence.size(); ++v) {
    if (valence[v] == 0) continue;
    int steps = 0;
    auto at = start[v];
    do {
      at = next.at((static_cast<std::uint64_t>(v) << 32) | at);
      ++steps;
    } while (at != start[v] && steps <= valence[v]);
    if (steps != valence[v]) return false;
  }
  return true;
}

Eigen::Vector3d area_vector(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>();
  const Eigen::Vector3d b = mesh.positions[t[1]].cast<double>();
  const Eigen::Vector3d c = mesh.positions[t[2]].cast<double>();
  return 0.5 * (b - a).cross(c - a);
}

}  // namespace

MeshTopology topology_of(const TriangleMesh& mesh) {
  MeshTopology topology;
  std::vector<int> valence(mesh.positions.size(), 0);
  for (const auto& triangle : mesh.triangles)
    for (const auto v : triangle) ++valence[v];
  const auto edges = count_edges(mesh);
  const auto used = std::count_if(valence.begin(), valence.end(), [](int n) { return n > 0; });
  topology.components = count_components(mesh, valence);
  topology.euler_characteristic =
      static_cast<long>(used) - static_cast<long>(edges.size()) + static_cast<long>(mesh.triangles.size());
  topology.closed = !mesh.triangles.empty() && std::all_of(edges.begin(), edges.end(), [](const auto& edge) {
    return edge.second.forward == 1 && edge.second.backward == 1;
  });
  topology.manifold = topology.closed && single_fans(mesh, valence);
  return topology;
}

void compute_normals(TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.positions.size(), Eigen::Vector3d::Zero());
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d area = area_vector(mesh, triangle);
    for (const auto v : triangle) sums[v] += area;
  }
  mesh.normals.resize(mesh.positions.size());
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const double length = sums[v].norm();
    mesh.normals[v] = length > 0.0 ? Eigen::Vector3f((sums[v] / length).cast<float>()) : Eigen::Vector3f::UnitZ();
  }
}

double signed_volume(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) sum += mesh.positions[t[0]].cast<double>().dot(area_vector(mesh, t)) / 3.0;
  return sum;
}

double surface_area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) sum += area_vector(mesh, t).norm();
  return sum;
}

}  // namespace rotunda::recon
