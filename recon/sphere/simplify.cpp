// Fine mesh -> tetrahedron: the collapses behind a progressive mesh.
#include <Eigen/Geometry>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "config/errors.h"
#include "recon/sphere/progressive_mesh.h"

namespace rotunda::recon {
namespace {

using Connectivity = OpenMesh::TriConnectivity;
using Vertex = OpenMesh::VertexHandle;
using Halfedge = OpenMesh::HalfedgeHandle;

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

// Sum of area-weighted squared distances to planes: x' A x + 2 b' x + c (Garland, Heckbert 1997).
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0.0;

  void add_plane(const Eigen::Vector3d& normal, double offset, double weight) {
    a += weight * normal * normal.transpose();
    b += weight * offset * normal;
    c += weight * offset * offset;
  }
  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    return *this;
  }
  double at(const Eigen::Vector3d& x) const { return std::max(0.0, x.dot(a * x) + 2.0 * b.dot(x) + c); }
};

struct Collapse {
  double cost = std::numeric_limits<double>::infinity();
  Halfedge halfedge;  // from the vertex that goes to the one that stays
};

// One queue entry a vertex, its cheapest collapse when it was queued; a stale entry has an old revision.
struct Candidate {
  double cost = 0.0;
  std::uint32_t vertex = 0;
  std::uint32_t revision = 0;
  bool operator<(const Candidate& other) const {
    return cost != other.cost ? cost > other.cost : vertex > other.vertex;
  }
};

class Simplifier {
 public:
  explicit Simplifier(const TriangleMesh& mesh) {
    add_vertices(mesh);
    add_faces(mesh);
    add_quadrics();
  }

  ProgressiveMesh run() {
    for (const auto vertex : surface_.vertices()) enqueue(vertex);
    while (remaining_ > 4) collapse(next_collapse());
    return record();
  }

 private:
  struct Undo {
    std::uint32_t vertex, parent, left, right, fine_count;
  };
  static std::size_t index(Vertex v) { return static_cast<std::size_t>(v.idx()); }
  const Eigen::Vector3d& point(Vertex v) const { return points_[index(v)]; }

  void add_vertices(const TriangleMesh& mesh) {
    compact_.assign(mesh.positions.size(), kUnused);
    for (const auto& triangle : mesh.triangles)
      for (const auto v : triangle) compact_[v] = 0;
    for (std::uint32_t v = 0; v < compact_.size(); ++v) {
      if (compact_[v] == kUnused) continue;
      compact_[v] = static_cast<std::uint32_t>(fine_vertex_.size());
      fine_vertex_.push_back(v);
      points_.push_back(mesh.positions[v].cast<double>());
      surface_.new_vertex();
    }
    remaining_ = points_.size();
    revision_.assign(remaining_, 0);
    fine_count_.assign(remaining_, 1);
    quadrics_.resize(remaining_);
    surface_.request_vertex_status();
    surface_.request_halfedge_status();
    surface_.request_edge_status();
    surface_.request_face_status();
  }

  void add_faces(const TriangleMesh& mesh) {
    surface_.reserve(remaining_, mesh.triangles.size() * 3 / 2, mesh.triangles.size());
    const auto vertex = [&](std::uint32_t v) { return Vertex(static_cast<int>(compact_[v])); };
    for (const auto& t : mesh.triangles)
      if (!surface_.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2])).is_valid())
        throw InvalidInput("mesh is not an edge-manifold surface; close it before mapping it to the sphere");
  }

  void add_quadrics() {
    for (const auto face : surface_.faces()) {
      std::array<Vertex, 3> corner;
      std::copy(surface_.cfv_begin(face), surface_.cfv_end(face), corner.begin());
      const Eigen::Vector3d cross = (point(corner[1]) - point(corner[0])).cross(point(corner[2]) - point(corner[0]));
      const double length = cross.norm();
      if (length <= 0.0) continue;
      for (const auto v : corner)
        quadrics_[index(v)].add_plane(cross / length, -cross.dot(point(corner[0])) / length, length / 6.0);
    }
  }

  // Worst shape among the triangles that survive when `gone` moves onto `kept`; 1 is equilateral. Triangles that turn
  // over or lose their area count as very bad, but never as impossible: the tetrahedron must be reached.
  double shape_after(Vertex gone, Vertex kept) {
    constexpr double kTurnedOver = 1e3;
    double worst = 1.0;
    for (auto it = surface_.cvoh_iter(gone); it.is_valid(); ++it) {
      const auto a = surface_.to_vertex_handle(*it);
      const auto b = surface_.to_vertex_handle(surface_.next_halfedge_handle(*it));
      if (a == kept || b == kept) continue;
      const Eigen::Vector3d edge = point(b) - point(a);
      const Eigen::Vector3d before = edge.cross(point(gone) - point(a)), after = edge.cross(point(kept) - point(a));
      if (before.dot(after) <= 0.2 * before.norm() * after.norm()) return kTurnedOver;
      const double edges =
          edge.squaredNorm() + (point(kept) - point(a)).squaredNorm() + (point(kept) - point(b)).squaredNorm();
      worst = std::max(worst, edges / (2.0 * std::sqrt(3.0) * after.norm()));
    }
    return std::min(worst, kTurnedOver);
  }

  double cost_of(Halfedge halfedge) {
    constexpr double kShape = 1e-3;  // share of the squared edge length that flat parts cost
    const auto gone = surface_.from_vertex_handle(halfedge), kept = surface_.to_vertex_handle(halfedge);
    const auto& quadric = quadrics_[index(gone)];
    const double flat = kShape * quadric.a.trace() * (point(gone) - point(kept)).squaredNorm();
    return (quadric.at(point(kept)) + flat) * shape_after(gone, kept);
  }

  Collapse cheapest(Vertex gone) {
    Collapse best;
    for (auto it = surface_.cvoh_iter(gone); it.is_valid(); ++it) {
      const double cost = cost_of(*it);
      if (cost < best.cost && surface_.is_collapse_ok(*it)) best = {cost, *it};
    }
    return best;
  }

  void enqueue(Vertex vertex) {
    const auto best = cheapest(vertex);
    if (best.halfedge.is_valid())
      queue_.push({best.cost, static_cast<std::uint32_t>(vertex.idx()), revision_[index(vertex)]});
  }

  // A blocked vertex (link condition) is queued again when a neighbour goes; a triangulated sphere of more than four
  // vertices always has an edge that may go, but it may have been blocked by a vertex two rings away.
  Halfedge next_collapse() {
    for (bool refilled = false;; refilled = true) {
      while (!queue_.empty()) {
        const auto candidate = queue_.top();
        queue_.pop();
        const Vertex vertex(static_cast<int>(candidate.vertex));
        if (surface_.status(vertex).deleted() || candidate.revision != revision_[candidate.vertex]) continue;
        const auto best = cheapest(vertex);
        if (best.halfedge.is_valid()) return best.halfedge;
      }
      if (refilled) throw InvalidInput("mesh cannot be simplified to a tetrahedron; is it a sphere?");
      for (const auto vertex : surface_.vertices()) enqueue(vertex);  // skips deleted vertices
    }
  }

  void collapse(Halfedge halfedge) {
    const auto gone = surface_.from_vertex_handle(halfedge), kept = surface_.to_vertex_handle(halfedge);
    const auto left = surface_.opposite_vh(halfedge), right = surface_.opposite_he_opposite_vh(halfedge);
    const auto id = [](Vertex v) { return static_cast<std::uint32_t>(v.idx()); };
    undo_.push_back({id(gone), id(kept), id(left), id(right), fine_count_[index(gone)]});
    quadrics_[index(kept)] += quadrics_[index(gone)];
    fine_count_[index(kept)] += fine_count_[index(gone)];
    surface_.collapse(halfedge);
    --remaining_;
    requeue(kept);
    for (auto it = surface_.cvv_iter(kept); it.is_valid(); ++it) requeue(*it);
  }

  void requeue(Vertex vertex) {
    ++revision_[index(vertex)];
    enqueue(vertex);
  }

  ProgressiveMesh record() {
    ProgressiveMesh result;
    std::vector<std::uint32_t> order(points_.size(), 0);
    const auto number = [&](std::uint32_t v) {
      order[v] = static_cast<std::uint32_t>(result.fine_vertex.size());
      result.fine_vertex.push_back(fine_vertex_[v]);
    };
    for (const auto vertex : surface_.vertices()) {
      result.base_fine_count[result.fine_vertex.size()] = fine_count_[index(vertex)];
      number(static_cast<std::uint32_t>(vertex.idx()));
    }
    std::size_t face_count = 0;
    for (const auto face : surface_.faces()) {
      std::size_t i = 0;
      for (auto it = surface_.cfv_iter(face); it.is_valid(); ++it)
        result.base[face_count][i++] = order[static_cast<std::size_t>(it->idx())];
      ++face_count;
    }
    for (auto it = undo_.rbegin(); it != undo_.rend(); ++it) {
      number(it->vertex);
      result.splits.push_back({order[it->parent], order[it->left], order[it->right], it->fine_count});
    }
    return result;
  }

  Connectivity surface_;
  std::vector<std::uint32_t> compact_, fine_vertex_;  // fine index -> own index and back
  std::vector<Eigen::Vector3d> points_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> fine_count_, revision_;
  std::priority_queue<Candidate> queue_;
  std::vector<Undo> undo_;
  std::size_t remaining_ = 0;
};

}  // namespace

ProgressiveMesh simplify_to_tetrahedron(const TriangleMesh& mesh) {
  if (!topology_of(mesh).is_sphere())
    throw InvalidInput("mesh is not a closed surface of genus 0; only such a mesh has a sphere map");
  Simplifier simplifier(mesh);
  return simplifier.run();
}

}  // namespace rotunda::recon
