#include "recon/mesh/vertex_rings.h"

namespace rotunda::recon {

// Every edge of a closed mesh is met once in each direction, so each neighbour is entered once.
VertexRings::VertexRings(const TriangleMesh& mesh) : start_(mesh.positions.size() + 1, 0) {
  for (const auto& t : mesh.triangles)
    for (const auto v : t) ++start_[v + 1];
  for (std::size_t v = 0; v + 1 < start_.size(); ++v) start_[v + 1] += start_[v];
  neighbours_.resize(start_.back());
  auto next = start_;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) neighbours_[next[t[i]]++] = t[(i + 1) % 3];
}

}  // namespace rotunda::recon
