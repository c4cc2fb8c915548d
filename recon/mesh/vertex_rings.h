#pragma once
// The neighbours of every vertex of a closed mesh, side by side in memory.
#include <cstdint>
#include <span>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

class VertexRings {
 public:
  explicit VertexRings(const TriangleMesh& mesh);  // closed: every edge has two triangles
  std::span<const std::uint32_t> operator[](std::size_t vertex) const {
    return {neighbours_.data() + start_[vertex], start_[vertex + 1] - start_[vertex]};
  }
  std::size_t size() const { return start_.size() - 1; }

 private:
  std::vector<std::uint32_t> start_, neighbours_;
};

}  // namespace rotunda::recon
