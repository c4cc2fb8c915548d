#pragma once
// Progressive mesh (Hoppe 1996): a closed genus-0 mesh as a tetrahedron and a list of vertex splits. Half-edge
// collapses by quadric error (Garland, Heckbert 1997) with a shape term: flat parts go first, tips of limbs last
// (Praun, Hoppe 2003, section 4). ALGORITHMS.md step 5. Pure and deterministic.
#include <array>
#include <cstdint>
#include <vector>

#include "recon/mesh/triangle_mesh.h"

namespace rotunda::recon {

// Undoes one collapse: the new vertex takes over the parent's neighbours from `left` to `right`, counter-clockwise
// from outside, both included. Vertices are numbered in the order in which they come in.
struct VertexSplit {
  std::uint32_t parent = 0;
  std::uint32_t left = 0;
  std::uint32_t right = 0;
  std::uint32_t fine_count = 1;  // vertices of the fine mesh that the new one stands for, itself included
};

struct ProgressiveMesh {
  std::vector<std::uint32_t> fine_vertex;                 // vertex -> its index in the fine mesh; base vertices first
  std::array<std::array<std::uint32_t, 3>, 4> base = {};  // faces of the tetrahedron, vertices 0 ... 3
  std::array<std::uint32_t, 4> base_fine_count = {};      // fine vertices that each base vertex stands for
  std::vector<VertexSplit> splits;                        // split k brings vertex 4 + k
};

// Needs topology_of(mesh).is_sphere() and at least four used vertices, else throws InvalidInput. Vertices that no
// triangle uses are left out.
ProgressiveMesh simplify_to_tetrahedron(const TriangleMesh& mesh);

// Connectivity while it is refined: for each vertex its neighbours, counter-clockwise from outside, and the number of
// fine vertices it stands for. At every moment the sum of fine_count is the size of the fine mesh.
class RefiningMesh {
 public:
  explicit RefiningMesh(const ProgressiveMesh& mesh);
  bool done() const { return next_ == mesh_->splits.size(); }
  std::vector<std::uint32_t> next_ring() const;  // 1-ring of the vertex that comes next, its parent first
  std::uint32_t split();                         // undoes the next collapse; the new vertex

  std::size_t vertex_count() const { return rings_.size(); }
  const std::vector<std::uint32_t>& ring(std::uint32_t vertex) const { return rings_[vertex]; }
  std::uint32_t fine_count(std::uint32_t vertex) const { return fine_count_[vertex]; }
  std::vector<std::array<std::uint32_t, 3>> triangles() const;

 private:
  const ProgressiveMesh* mesh_;
  std::size_t next_ = 0;
  std::vector<std::vector<std::uint32_t>> rings_;
  std::vector<std::uint32_t> fine_count_;
};

// The mesh with `vertex_count` vertices (4 ... all), with the fine mesh's positions; vertex order as they come in.
TriangleMesh level_of(const ProgressiveMesh& progressive, const TriangleMesh& fine, std::size_t vertex_count);

}  // namespace rotunda::recon
