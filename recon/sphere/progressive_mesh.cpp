#include "recon/sphere/progressive_mesh.h"

#include <algorithm>

#include "config/errors.h"

namespace rotunda::recon {
namespace {

using Ring = std::vector<std::uint32_t>;

void insert_before(Ring& ring, std::uint32_t vertex, std::uint32_t before) {
  ring.insert(std::find(ring.begin(), ring.end(), before), vertex);
}

void insert_after(Ring& ring, std::uint32_t vertex, std::uint32_t after) {
  ring.insert(std::find(ring.begin(), ring.end(), after) + 1, vertex);
}

// The ring of a base vertex: one of its faces gives the first two neighbours in order, the third closes it.
Ring base_ring(const ProgressiveMesh& mesh, std::uint32_t vertex) {
  for (const auto& face : mesh.base)
    for (std::size_t i = 0; i < 3; ++i)
      if (face[i] == vertex) return {face[(i + 1) % 3], face[(i + 2) % 3], 6 - face[0] - face[1] - face[2]};
  return {};
}

}  // namespace

RefiningMesh::RefiningMesh(const ProgressiveMesh& mesh) : mesh_(&mesh) {
  rings_.reserve(4 + mesh.splits.size());
  fine_count_.assign(mesh.base_fine_count.begin(), mesh.base_fine_count.end());
  for (std::uint32_t v = 0; v < 4; ++v) rings_.push_back(base_ring(mesh, v));
}

std::vector<std::uint32_t> RefiningMesh::next_ring() const {
  const auto& step = mesh_->splits[next_];
  const auto& parent = rings_[step.parent];
  std::vector<std::uint32_t> ring = {step.parent};
  auto at = std::find(parent.begin(), parent.end(), step.left);
  for (;; ++at) {
    if (at == parent.end()) at = parent.begin();
    ring.push_back(*at);
    if (*at == step.right) return ring;
  }
}

std::uint32_t RefiningMesh::split() {
  auto ring = next_ring();
  const auto& step = mesh_->splits[next_++];
  const auto added = static_cast<std::uint32_t>(rings_.size());
  auto& parent = rings_[step.parent];
  std::rotate(parent.begin(), std::find(parent.begin(), parent.end(), step.left), parent.end());
  const auto right = std::find(parent.begin(), parent.end(), step.right);

  // Around the parent: left, x1 ... xk, right, the rest. The new vertex takes the x.
  for (auto x = parent.begin() + 1; x != right; ++x)
    std::replace(rings_[*x].begin(), rings_[*x].end(), step.parent, added);
  parent.erase(parent.begin() + 1, right);
  parent.insert(parent.begin() + 1, added);
  insert_before(rings_[step.left], added, step.parent);
  insert_after(rings_[step.right], added, step.parent);
  rings_.push_back(std::move(ring));

  fine_count_[step.parent] -= step.fine_count;
  fine_count_.push_back(step.fine_count);
  return added;
}

std::vector<std::array<std::uint32_t, 3>> RefiningMesh::triangles() const {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(2 * rings_.size() - 4);
  for (std::uint32_t v = 0; v < rings_.size(); ++v)
    for (std::size_t i = 0; i < rings_[v].size(); ++i) {
      const auto a = rings_[v][i], b = rings_[v][(i + 1) % rings_[v].size()];
      if (v < a && v < b) triangles.push_back({v, a, b});
    }
  return triangles;
}

TriangleMesh level_of(const ProgressiveMesh& progressive, const TriangleMesh& fine, std::size_t vertex_count) {
  if (vertex_count < 4 || vertex_count > progressive.fine_vertex.size())
    throw InvalidInput("a level of the progressive mesh has between 4 vertices and all of them");
  RefiningMesh refining(progressive);
  while (refining.vertex_count() < vertex_count) refining.split();
  TriangleMesh level;
  for (std::size_t v = 0; v < vertex_count; ++v) level.positions.push_back(fine.positions[progressive.fine_vertex[v]]);
  level.triangles = refining.triangles();
  return level;
}

}  // namespace rotunda::recon
